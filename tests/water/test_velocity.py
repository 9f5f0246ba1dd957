"""Profiles of pipe flow and gusts, against textbooks, quadrature, finite differences and statistics."""

import math
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from driftform.motion.forces.model import flight_model
from driftform.motion.forces.terminal import terminal_speed_across
from driftform.study import load_study
from driftform.testing.agents import sphere_agent
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import (
    DevelopingFlow,
    Gusts,
    LogLawFlow,
    PowerLawFlow,
    TurbulentFlow,
    UniformFlow,
    friction_factor,
    friction_velocity,
)
from driftform.water.gusts import draw_gusts, eddy_diffusivity, gust_motion, gust_numbers, shortest_memory
from driftform.water.parts.profiles import AT_A_POINT, MIN_WALL_DISTANCE
from driftform.water.scenario import FlightLimits
from driftform.water.velocity import FRICTION, gust_at, water_motion

SHEAR = 0.0362
"""Friction velocity of 1 m/s in the pipe of 2 m, m/s: Re = 1.9e6."""

PROFILES = {
    "power law": PowerLawFlow(speed=0.8, exponent=6.5),
    "log law": LogLawFlow(speed=1.3),
    "rough wall": LogLawFlow(speed=1.3, roughness=2e-3),
    "developing": DevelopingFlow(speed=0.7),
}

profiles = st.sampled_from(list(PROFILES.values()))
turns = st.tuples(*[st.floats(-3, 3)] * 3)


def scenario_of(flow, radius=1.0, start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), horizon=20.0):
    return Scenario(
        pipe=Pipe(segments=(Segment(start=start, end=end, radius=radius),)),
        flow=flow,
        fluid=Fluid(viscosity=1.05e-6),
        release={"position": start, "frame": "world"},
        flight=FlightLimits(horizon=horizon),
    )


class Stream:
    """The water of a scenario: velocity, gradient and rate at any point."""

    def __init__(self, scenario):
        model = flight_model(sphere_agent(0.01, 0.05), scenario)
        self._arrays = model.pipe, model.flow

    def __call__(self, point, t=0.0):
        velocity, gradient, rate = water_motion(tuple(float(p) for p in point), float(t), *self._arrays)
        return np.array(velocity), np.array(gradient), np.array(rate)

    def velocity(self, point, t=0.0):
        return self(point, t)[0]


@cache
def stream_of(flow, **pipe):
    return Stream(scenario_of(flow, **pipe))


def differences(stream, point, h):
    """du_i/dx_j by central differences of the fourth order."""
    columns = []
    for j in range(3):
        e = h * np.eye(3)[j]
        one = stream.velocity(point + e) - stream.velocity(point - e)
        two = stream.velocity(point + 2 * e) - stream.velocity(point - 2 * e)
        columns.append((8 * one - two) / (12 * h))
    return np.column_stack(columns)


# Friction.


@pytest.mark.parametrize(
    ("reynolds", "roughness", "f"),
    [
        # White, Fluid Mechanics, section 6.6: Prandtl's law for smooth pipes.
        (4e3, 0.0, 0.0399),
        (1e4, 0.0, 0.0309),
        (1e5, 0.0, 0.0180),
        (1e6, 0.0, 0.0116),
        (1e7, 0.0, 0.0081),
        (1e8, 0.0, 0.0059),
        # The same, fully rough: the friction no longer depends on the Reynolds number.
        (1e12, 0.00001, 0.00806),
        (1e12, 0.0001, 0.0120),
        (1e12, 0.001, 0.0196),
        (1e12, 0.01, 0.0379),
        (1e12, 0.05, 0.0716),
        # The pipe of the default study.
        (1.9e6, 0.0, 0.01046),
    ],
)
def test_the_friction_factor_is_that_of_the_tables(reynolds, roughness, f):
    digits = len(str(f)) - 2
    assert friction_factor(reynolds, roughness) == pytest.approx(f, abs=0.51 * 10**-digits)


# Profiles.


@pytest.mark.parametrize(
    ("y", "ratio"), [(1.0, 1.136), (0.5, 1.073), (0.2, 0.990), (0.1, 0.927), (0.05, 0.864), (0.01, 0.718)]
)
def test_the_log_law_is_the_published_profile_of_a_2_m_pipe_at_1_m_s(y, ratio):
    # The printed values have u* = 0.0363 m/s, and three digits: off by |3/2 + ln y| 1e-4 / 0.4 and half a digit.
    tolerance = abs(1.5 + math.log(y)) * 1e-4 / 0.4 + 6e-4
    for speed, digits in ((1.0, tolerance), (2.0, 0.02)):
        velocity = stream_of(LogLawFlow(speed=speed)).velocity([4.0, 0.0, 1 - y])
        assert velocity / speed == pytest.approx([ratio, 0, 0], abs=digits)


@pytest.mark.parametrize("n", [6.0, 7.0, 9.0, 10.0])
def test_the_power_law_is_fastest_on_the_axis_by_its_known_ratio(n):
    stream = stream_of(PowerLawFlow(speed=0.5, exponent=n))
    ratio = (n + 1) * (2 * n + 1) / (2 * n * n)
    assert stream.velocity([2.0, 0.0, 0.0])[0] == pytest.approx(0.5 * ratio, rel=1e-12)
    assert stream.velocity([2.0, 0.0, 0.7])[0] == pytest.approx(0.5 * ratio * 0.3 ** (1 / n), rel=1e-12)


def test_a_pipe_of_9_m_ends_before_its_boundary_layers_meet():
    stream = stream_of(DevelopingFlow(speed=1.0))
    assert stream.velocity([9.0, 0.0, 0.0])[0] == pytest.approx(1.035, abs=1.5e-3)
    # The layer is 0.37 x Re_x^(-1/5) thick: the core is of one speed up to there, and slower at once beyond.
    layer = 0.37 * 9.0 * (9.0 / 1.05e-6) ** -0.2
    core = [stream.velocity([9.0, 0.0, r])[0] for r in (0.0, 0.4, 0.999 * (1 - layer))]
    assert core == pytest.approx([core[0]] * 3, rel=1e-12)
    assert stream.velocity([9.0, 0.0, 1 - 0.5 * layer])[0] == pytest.approx(core[0] * 0.5 ** (1 / 7), rel=1e-9)
    assert stream.velocity([1e-3, 0.0, 0.0])[0] == pytest.approx(1.0, abs=1e-3), "it enters uniformly"


@pytest.mark.parametrize("what", PROFILES)
@pytest.mark.parametrize("x", [0.5, 8.5, 300.0])
def test_the_mean_over_the_cross_section_is_the_bulk_speed(what, x):
    flow = PROFILES[what]
    stream = stream_of(flow, end=(400.0, 0.0, 0.0))

    def flux(r):
        return 2 * r * stream.velocity([x, 0.0, r])[0]

    layer = min(1.0, 0.37 * x**0.8 * (1.05e-6 / flow.speed) ** 0.2)
    ends = sorted({0.0, 1 - layer, 1 - MIN_WALL_DISTANCE, 1.0})
    mean = sum(quad(flux, a, b, epsabs=1e-12, epsrel=1e-10)[0] for a, b in pairwise(ends))
    # Within NEAREST of the wall the speed is constant, where the law has less: up to 3e-4 of the bulk speed in the mean.
    assert 0 <= mean / flow.speed - 1 < 3e-4


def places(flow):
    """Points of the bore away from where a profile has a kink: the axis, the core's edge, NEAREST of the wall."""
    return st.tuples(st.floats(0.05, 8.9), st.floats(0.01, 0.98), st.floats(0, 2 * np.pi)).filter(
        lambda p: (
            not isinstance(flow, DevelopingFlow)
            or abs(1 - p[1] - 0.37 * p[0] ** 0.8 * (1.05e-6 / flow.speed) ** 0.2) > 2e-3
        )
    )


def point_at(x, r, angle):
    return np.array([x, r * math.cos(angle), r * math.sin(angle)])


@given(profiles.flatmap(lambda flow: st.tuples(st.just(flow), places(flow))))
def test_the_gradient_is_the_change_of_the_velocity(drawn):
    flow, (x, r, angle) = drawn
    stream, point = stream_of(flow), point_at(x, r, angle)
    _, gradient, rate = stream(point)
    found = differences(stream, point, 2e-4)
    # u ~ y^(1/7) and ln y have a fifth derivative of up to 24 u / y^5, and the distance r from the axis one of up to
    # 45 / r^4: off by h^4 / 30 of that.
    tolerance = (2e-4) ** 4 / 30 * (24 * flow.speed / (1 - r) ** 5 + 45 * abs(gradient).max() / r**4) + 1e-8
    left_out = np.zeros((3, 3))
    if isinstance(flow, DevelopingFlow):
        # The change downstream of the radial velocity, u_r of the order of U d' / 8: (d'/8)' U, with d ~ x^0.8.
        layer = 0.37 * x**0.8 * (1.05e-6 / flow.speed) ** 0.2
        outward = point_at(0.0, 1.0, angle)
        radial = outward @ (found - gradient) @ [1, 0, 0]
        left_out = radial * np.outer(outward, [1, 0, 0])
        assert abs(radial) < 0.25 * flow.speed * (0.8 * layer / x) ** 2 / layer
    assert gradient == pytest.approx(found - left_out, abs=tolerance)
    assert rate == pytest.approx([0, 0, 0], abs=0)


@given(places(DevelopingFlow()))
def test_water_that_slows_down_in_the_layer_goes_inward_and_none_is_lost(place):
    stream, point = stream_of(DevelopingFlow(speed=1.0)), point_at(*place)
    found = differences(stream, point, 2e-4)
    size = np.abs(np.diag(found)).max()
    tolerance = (2e-4) ** 4 / 30 * (24 / (1 - place[1]) ** 5 + 45 * size / place[1] ** 4) + 1e-8
    assert np.trace(found) == pytest.approx(0, abs=1e-6 * size + tolerance)
    assert np.trace(stream(point)[1]) == pytest.approx(0, abs=1e-14)
    assert stream.velocity(point) @ point_at(0.0, 1.0, place[2]) <= 0


@pytest.mark.parametrize("what", PROFILES)
@pytest.mark.parametrize("x", [0.2, 4.0, 8.9])
def test_no_water_goes_through_the_wall(what, x):
    flow = PROFILES[what]
    stream = stream_of(flow)
    layer = 0.37 * x**0.8 * (1.05e-6 / flow.speed) ** 0.2
    for y in (0.05, 0.01, MIN_WALL_DISTANCE, 0.0):
        radial = stream.velocity(point_at(x, 1 - y, 1.0)) @ point_at(0.0, 1.0, 1.0)
        # At the layer's edge it is the growth of the displaced thickness, U d' / 8, and falls as y^(8/7).
        bound = 1.1 * flow.speed * 0.1 * layer / x * min(1.0, max(y, MIN_WALL_DISTANCE) / layer) ** (8 / 7)
        assert abs(radial) <= (bound if isinstance(flow, DevelopingFlow) else 1e-15)


@given(
    st.sampled_from([*PROFILES.values(), UniformFlow(speed=0.9)]),
    turns,
    st.tuples(*[st.floats(-3, 3)] * 3),
    st.tuples(st.floats(0.01, 8.9), st.floats(1e-3, 0.99), st.floats(0, 2 * np.pi)),
)
def test_a_pipe_in_any_direction_has_the_same_flow_turned(flow, turn, start, place):
    frame, start = Rotation.from_rotvec(turn).as_matrix(), np.array(start)
    end = start + frame @ [9.0, 0.0, 0.0]
    point = point_at(*place)
    velocity, gradient, _ = stream_of(flow)(point)
    turned, its_gradient, _ = stream_of(flow, start=tuple(start), end=tuple(end))(start + frame @ point)
    # Coordinates are rounded by 1e-15: that shifts the distance y from the wall, and turns the direction to it by
    # 1e-15 / r. On the axis itself, where power law and log law have a cusp, the shear has no direction.
    y = 1 - place[1]
    assert turned == pytest.approx(frame @ velocity, abs=1e-13 / y)
    assert its_gradient == pytest.approx(frame @ gradient @ frame.T, abs=1e-13 / y**2 + 1e-14 / place[1])


def test_the_flow_beyond_the_wall_and_outside_the_pipes_ends_is_finite_and_goes_on():
    for flow in PROFILES.values():
        stream = stream_of(flow)
        for point in ([-0.5, 0, 0.3], [9.4, 0, 0.3], [3.0, 0, 1.2], [0.0, 0, 0.0], [0.0, 0, 1.0]):
            for values in stream(point):
                assert np.isfinite(values).all()
        assert stream.velocity([9.4, 0, 0.3])[0] == pytest.approx(stream.velocity([9.0, 0, 0.3])[0], rel=2e-3)
        # The body's centre may bounce at the wall: the velocity there does not jump.
        inside, outside = stream.velocity([3.0, 0, 1 - 1e-9]), stream.velocity([3.0, 0, 1 + 1e-9])
        assert outside == pytest.approx(inside, abs=1e-9)


def test_a_rough_wall_slows_the_water_beside_it_to_rest_and_no_further():
    # The wall is so rough that the law of the core would have the water go back.
    stream = stream_of(LogLawFlow(speed=1.0, roughness=0.1), radius=1.0)
    for y in np.geomspace(1e-4, 0.5, 200):
        velocity, gradient, _ = stream([2.0, 0.0, 1 - y])
        assert velocity[0] >= 0
        if velocity[0] == 0:
            assert gradient == pytest.approx(np.zeros((3, 3)), abs=0)
    assert stream.velocity([2.0, 0.0, 0.999])[0] == 0


@given(turns, st.floats(0, 19), st.floats(-2, 2))
def test_a_uniform_current_speeds_up_along_its_pipe(turn, t, acceleration):
    frame = Rotation.from_rotvec(turn).as_matrix()
    stream = stream_of(UniformFlow(speed=0.4, acceleration=acceleration), end=tuple(frame @ [9.0, 0.0, 0.0]))
    velocity, gradient, rate = stream(frame @ [3.0, 0.4, 0.1], t)
    assert velocity == pytest.approx((0.4 + acceleration * t) * frame[:, 0], abs=1e-12)
    assert gradient == pytest.approx(np.zeros((3, 3)), abs=0)
    assert rate == pytest.approx(acceleration * frame[:, 0], abs=1e-12)


# Gusts.

GUSTY = TurbulentFlow(speed=1.0)
SEEDS = 200
STEP = 0.2


def walk_of(seed, length=0.0):
    return draw_gusts(Gusts(seed=seed), 1024, 1.0, length)


@pytest.fixture(scope="module")
def walks():
    """The first walks of many seeds at every knot, (seeds x components, times)."""
    return np.concatenate([walk_of(seed)[:, :3].T for seed in range(SEEDS)])


def body_in_gusts(scenario, size=0.01):
    model = flight_model(sphere_agent(size, 0.05), scenario)
    return model.pipe, model.flow, model.gusts, model.eddies


def test_the_same_seed_has_the_same_gusts_and_another_seed_others():
    assert np.array_equal(walk_of(7), walk_of(7))
    assert not np.isclose(walk_of(7)[:, :3], walk_of(8)[:, :3], atol=1e-6).any()


def test_a_walk_lasts_until_the_horizon_even_at_the_wall():
    for horizon in (20.0, 200.0):
        _, flow, walk, _ = body_in_gusts(scenario_of(GUSTY, horizon=horizon))
        shortest = shortest_memory(flow, [(1.0, flow[FRICTION])])
        assert len(walk) >= horizon / (STEP * shortest)
    assert body_in_gusts(scenario_of(LogLawFlow()))[2].shape == (0, 12)


def test_gusts_have_no_mean_and_their_variance_from_the_start_on(walks):
    count = len(walks)
    for k in (0, 50, 200):
        # Four standard errors of the mean and of the variance of so many normal numbers.
        assert walks[:, k].mean() == pytest.approx(0, abs=4 / math.sqrt(count))
        assert walks[:, k].var() == pytest.approx(1, abs=4 * math.sqrt(2 / count))
    # 1024 steps are 205 memories, of which each half brings a new value of the square.
    assert (walks**2).mean() == pytest.approx(1, abs=4 * math.sqrt(2 / (205 * count)))


@pytest.mark.parametrize("lag", [0.2, 1.0, 3.0])
def test_gusts_are_forgotten_exponentially_within_their_memory(walks, lag):
    step, kept = round(lag / STEP), math.exp(-lag)
    products = walks[:, 20] * walks[:, 20 + step]
    assert products.mean() == pytest.approx(kept, abs=4 * math.sqrt((1 + kept**2) / len(walks)))


def test_the_components_of_gusts_are_independent(walks):
    x, y, z = walks.reshape(SEEDS, 3, -1)[:, :, 100].T
    for a, b in ((x, y), (y, z), (z, x)):
        assert (a * b).mean() == pytest.approx(0, abs=4 / math.sqrt(SEEDS))


@pytest.mark.parametrize("length", [0.05, 0.3, 2.0])
def test_gusts_at_two_points_of_a_body_have_the_correlation_of_their_distance(length):
    gusts = Gusts()
    # The size of the eddies: the way of a gust within its memory in the core, over beta.
    apart, size = length / math.sqrt(3), 0.4 / 6 / 0.8 / 0.5
    share = gust_numbers(gusts, 1.0, 0.0, length)[1] / 0.8
    rows = share * np.concatenate([walk_of(seed, length)[::30] for seed in range(SEEDS)])
    fore, aft = (rows[:, :3] + side * apart / 2 * rows[:, 6:9] for side in (1, -1))
    slack = 6 / math.sqrt(fore.size)
    for gust in (fore, aft):
        assert (gust**2).mean() == pytest.approx(1, abs=slack)
    assert (fore * aft).mean() == pytest.approx(math.exp(-apart / size), abs=slack)


def test_the_walk_is_a_periodic_cubic_spline():
    walk = walk_of(3, 0.3)
    times = STEP * np.arange(len(walk) + 1)
    for first in (0, 6):
        values = np.concatenate([walk, walk[:1]])[:, first : first + 3]
        slopes = CubicSpline(times, values, bc_type="periodic")(times[:-1], 1)
        np.testing.assert_allclose(walk[:, first + 3 : first + 6], slopes, atol=1e-9)


@pytest.mark.parametrize("slip", [0.05, 0.5])
def test_a_body_that_moves_through_the_water_forgets_gusts_as_csanady_says(slip):
    friction, radius = SHEAR, 1.0
    flow = np.zeros(FRICTION + 1)
    flow[4:8] = gust_numbers(Gusts(), radius, slip)
    bore = ((0.0, 0.0, 1.0), radius, 0.3, friction)
    eddies = np.zeros((2, 4))
    gust_motion(bore, (1.0, 0.0, 0.0), flow, walk_of(1), eddies)
    memory = 0.4 * radius / 6 / (0.64 * friction)
    expected = memory / math.sqrt(1 + (0.5 * slip / (0.8 * friction)) ** 2)
    assert 1 / eddies[1, 0] == pytest.approx(expected, rel=1e-12)


def test_memory_is_what_the_diffusivity_of_the_profile_asks_for():
    scenario = scenario_of(GUSTY)
    pipe, flow, walk, eddies = body_in_gusts(scenario, 1e-3)
    friction = flow[FRICTION]
    assert friction == pytest.approx(SHEAR, rel=2e-3)
    for y in (0.02, 0.1, 0.2):
        point = (4.0, 1 - y, 0.0)
        mean, gradient, _ = water_motion(point, 0.0, pipe, flow)
        gust_at(point, mean, pipe, flow, walk, eddies)
        # Reynolds' analogy, without the mean square distance of the body.
        diffusivity = friction**2 * (1 - y) / abs(gradient[0][1])
        assert (0.8 * friction) ** 2 / eddies[1, 0] == pytest.approx(diffusivity, rel=1e-9)
    for y in (0.25, 0.6, 1.0):
        assert eddy_diffusivity(y, 1.0) == pytest.approx(0.4 / 6)


@given(st.floats(0.0, 0.979), st.floats(0, 2 * math.pi), st.floats(0.01, 30), st.tuples(*[st.floats(-1, 1)] * 3))
def test_the_rate_of_a_gust_is_its_change_along_the_path_of_the_water(r, turn, tau, h):
    pipe, flow, walk, eddies = body_in_gusts(scenario_of(GUSTY), 0.02)
    point = (3.0, r * math.cos(turn), r * math.sin(turn))

    def state(at, times):
        eddies[0] = times
        mean = water_motion(tuple(at.tolist()), 0.0, pipe, flow)[0]
        found = gust_at(tuple(at.tolist()), mean, pipe, flow, walk, eddies)
        return np.array(mean), np.array(found[0]), np.array(found[1]), eddies[1].copy()

    here, now = np.array(point), np.array([tau, *h])
    mean, gust, rate, rates = state(here, now)
    ends = [state(here + dt * (mean + gust), now + dt * rates)[1] for dt in (1e-5, -1e-5)]
    scale = np.abs(rates[0]) * (1 + np.abs(h).max()) * 0.8 * SHEAR
    assert (ends[0] - ends[1]) / 2e-5 == pytest.approx(rate, abs=1e-3 * scale + 1e-6)


def test_a_body_with_drag_meets_gusts_that_differ_along_it_and_one_without_does_not():
    pipeline = load_study("paper", ["hydrodynamics.drag=strips"]).make_pipeline()
    agent = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(1)))
    ideal = replace(agent, coefficients=replace(agent.coefficients, drag=None))
    for crossing, body, differs in ((0.5, agent, True), (0.0, agent, False), (0.5, ideal, False)):
        scenario = scenario_of(GUSTY).model_copy(update={"gusts": Gusts(crossing=crossing)})
        model = flight_model(body, scenario)
        point, mean = (1.0, 0.0, 0.0), (1.0, 0.0, 0.0)
        _, _, shear = gust_at(point, mean, model.pipe, model.flow, model.gusts, model.eddies)
        assert (min(map(abs, shear)) > 0) == differs
    slip = terminal_speed_across(agent.coefficients.drag, agent.mass.net_buoyancy(Fluid()), 1024.0, 1.05e-6)
    model = flight_model(agent, scenario_of(GUSTY))
    assert model.flow[4:8] == pytest.approx(gust_numbers(Gusts(), 1.0, slip, agent.body.length))


def test_every_bore_of_a_junction_has_gusts_of_its_own_memory():
    parts = [{"length": 2.0}, {"kind": "reducer", "length": 0.5, "radius": 0.05}, {"length": 2.0}]
    scenario = Scenario.model_validate(
        {"pipe": {"radius": 0.1, "parts": parts}, "flow": {"kind": "turbulent", "speed": 0.5}}
    )
    model = flight_model(sphere_agent(1e-3, 4e-6), scenario)
    for x, radius, speed in ((1.0, 0.1, 0.5), (3.5, 0.05, 2.0)):
        point = (x, 0.0, 0.0)
        mean = water_motion(point, 0.0, model.pipe, model.flow, AT_A_POINT, model.fittings)[0]
        gust_at(point, mean, model.pipe, model.flow, model.gusts, model.eddies, model.fittings)
        friction = friction_velocity(scenario.flow, radius, speed, scenario.fluid.viscosity)
        assert 1 / model.eddies[1, 0] == pytest.approx(0.4 * radius / 6 / (0.64 * friction), rel=1e-9)
