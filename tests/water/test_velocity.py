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
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from driftform.motion.model import flight_model
from driftform.motion.terminal import terminal_speed_across
from driftform.study import load_study
from driftform.testing.agents import sphere_agent
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import (
    DevelopingFlow,
    LogLawFlow,
    PowerLawFlow,
    TurbulentFlow,
    UniformFlow,
    friction_factor,
)
from driftform.water.profiles import MIN_WALL_DISTANCE
from driftform.water.scenario import FlightLimits
from driftform.water.velocity import (
    find_spline_slopes,
    flow_array,
    gust_array,
    gust_memory,
    gust_shear,
    water_motion,
)

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
        self._arrays = model.pipe, model.flow, model.gusts

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


@given(st.floats(math.log(4e3), math.log(1e8)), st.floats(0, 0.05))
def test_the_friction_factor_solves_colebrooks_equation(logarithm, roughness):
    reynolds = math.exp(logarithm)

    def residual(f):
        root = math.sqrt(f)
        return 1 / root + 2 * math.log10(roughness / 3.7 + 2.51 / (reynolds * root))

    assert friction_factor(reynolds, roughness) == pytest.approx(brentq(residual, 1e-3, 1.0), rel=1e-9)


# Profiles.


def test_the_log_law_has_the_friction_velocity_of_its_wall():
    # du/dr = -u* / (0.4 y): the shear tells u*.
    _, gradient, _ = stream_of(LogLawFlow(speed=1.0))([3.0, 0.0, 0.9])
    assert -gradient[0, 2] * 0.4 * 0.1 == pytest.approx(SHEAR, abs=5e-5)
    assert pytest.approx(math.sqrt(0.01046 / 8), abs=5e-5) == SHEAR


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
    assert stream.velocity([9.0, 0.0, 1 - 0.5 * layer])[0] == pytest.approx(
        core[0] * 0.5 ** (1 / 7), rel=1e-9
    )
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
    # What the constant within NEAREST of the wall adds: by the log law 2 NEAREST u* / (0.4 U), 2e-4 of the bulk
    # speed; by a power law u ~ y^p the share 2 p / (1 + p) NEAREST^(1 + p) of the speed on the axis, 1e-4.
    if isinstance(flow, LogLawFlow):
        f = friction_factor(2 * flow.speed / 1.05e-6, flow.roughness / 2)
        excess = 2 * math.sqrt(f / 8) / 0.4 * (MIN_WALL_DISTANCE - MIN_WALL_DISTANCE**2 / 4)
    else:
        p = 1 / flow.exponent if isinstance(flow, PowerLawFlow) else 1 / 7
        thickness = 1.0 if isinstance(flow, PowerLawFlow) else layer
        top = stream.velocity([x, 0.0, 0.0])[0] / flow.speed
        excess = (
            2
            * p
            * top
            * (MIN_WALL_DISTANCE / thickness) ** p
            * (MIN_WALL_DISTANCE / (1 + p) - MIN_WALL_DISTANCE**2 / (2 * (2 + p)))
        )
    assert excess < 3e-4
    assert mean / flow.speed - 1 == pytest.approx(excess, abs=1e-8)


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


def test_the_volume_flow_into_a_growing_layer_comes_from_the_core():
    # Through a cylinder of radius r within x1 to x2 flows as much as passes its ends more or less.
    stream, r, ends = stream_of(DevelopingFlow(speed=1.0)), 0.95, (3.0, 6.0)

    def through(x):
        def flux(s):
            return 2 * np.pi * s * stream.velocity([x, 0.0, s])[0]

        edge = 1 - 0.37 * x**0.8 * 1.05e-6**0.2
        return sum(quad(flux, a, b, epsrel=1e-12)[0] for a, b in ((0, min(r, edge)), (min(r, edge), r)))

    # The layer's edge passes this radius at x = 2.6 m, so that nothing has a kink on the way.
    side = quad(lambda x: 2 * np.pi * r * stream.velocity([x, 0.0, r])[2], *ends, epsrel=1e-12)[0]
    assert side < -1e-4
    assert through(ends[1]) - through(ends[0]) == pytest.approx(-side, rel=1e-6)


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


@given(st.floats(0.5, 1), turns.filter(lambda a: np.linalg.norm(a) > 0.1))
def test_the_flow_of_the_first_segment_goes_on_in_a_second_one_in_line(x, turn):
    one = stream_of(DevelopingFlow(speed=1.0))
    scenario = scenario_of(DevelopingFlow(speed=1.0))
    model = flight_model(sphere_agent(0.01, 0.05), scenario)
    pipe = np.array([[0.0, 0, 0, 1, 0, 0, 4, 1.0], [4.0, 0, 0, 1, 0, 0, 5, 1.0]])
    point = (3.5 + x, *(0.5 * np.array(turn[:2]) / np.linalg.norm(turn)).tolist())
    velocity, gradient, _ = water_motion(point, 0.0, pipe, model.flow, model.gusts)
    assert velocity == pytest.approx(one.velocity(point), rel=1e-12, abs=1e-15)
    assert np.array(gradient) == pytest.approx(one(point)[1], rel=1e-9, abs=1e-12)


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
GUST = 0.8 * SHEAR
"""Standard deviation of each component, m/s."""

SEEDS = 400


def gusts_of(seed, **changes):
    flow = GUSTY.model_copy(update={"seed": seed, **changes})
    return gust_array(scenario_of(flow))


@pytest.fixture(scope="module")
def walks():
    """The gusts of many seeds every 0.1 s, (seeds x components, times)."""
    return np.concatenate([gusts_of(seed)[:, :3].T for seed in range(SEEDS)])


def test_the_same_seed_has_the_same_gusts_and_another_seed_others():
    assert np.array_equal(gusts_of(7), gusts_of(7))
    assert not np.isclose(gusts_of(7)[:, :3], gusts_of(8)[:, :3], atol=1e-6).any()


def test_every_evaluation_of_a_run_meets_gusts_of_its_own():
    scenario = scenario_of(GUSTY)
    seeds = [scenario.of_evaluation(seed, index).flow.seed for seed in (1, 2) for index in range(50)]
    assert len(set(seeds)) == 100
    assert scenario.of_evaluation(1, 3) == scenario.of_evaluation(1, 3)
    calm = scenario_of(LogLawFlow(speed=1.0))
    assert calm.of_evaluation(1, 3) is calm


def test_gusts_last_until_the_horizon_and_without_intensity_there_are_none():
    stream = Stream(scenario_of(GUSTY, horizon=2.03))
    assert np.abs(np.diff([stream.velocity([1, 0, 0], t)[0] for t in (1.9, 1.97, 2.03)])).min() > 1e-9
    assert gusts_of(0, intensity=0.0).shape == (0, 12)
    assert gust_array(scenario_of(LogLawFlow())).shape == (0, 12)


def test_gusts_have_no_mean_and_their_variance_from_the_start_on(walks):
    count = len(walks)
    for k in (0, 50, 200):
        sample = walks[:, k] / GUST
        # Four standard errors of the mean and of the variance of so many normal numbers.
        assert sample.mean() == pytest.approx(0, abs=4 / math.sqrt(count))
        assert sample.var() == pytest.approx(1, abs=4 * math.sqrt(2 / count))
    # Over 20 s, of which every 3 s / 2 bring a new value of the square.
    mean_square = (walks[:, :201] ** 2).mean() / GUST**2
    assert mean_square == pytest.approx(1, abs=4 * math.sqrt(2 * 3.0 / (20 * count)))


@pytest.mark.parametrize("length", [0.05, 0.3, 2.0])
def test_gusts_at_two_points_of_a_body_have_the_correlation_of_their_distance(length):
    apart, size = length / math.sqrt(3), GUST * 3.0 / 0.5
    rows = np.concatenate(
        [gust_array(scenario_of(replace_seed(seed)), 0.0, length)[::60] for seed in range(SEEDS)]
    )
    fore, aft = (rows[:, :3] + side * apart / 2 * rows[:, 6:9] for side in (1, -1))
    slack = 6 / math.sqrt(fore.size)
    for gust in (fore, aft):
        assert (gust**2).mean() / GUST**2 == pytest.approx(1, abs=slack)
    assert (fore * aft).mean() / GUST**2 == pytest.approx(math.exp(-apart / size), abs=slack)


def replace_seed(seed):
    return GUSTY.model_copy(update={"seed": seed})


@pytest.mark.parametrize("slip", [0.05, 0.5])
def test_a_body_that_moves_through_the_water_forgets_gusts_as_csanady_says(slip):
    memory = 3.0 / math.sqrt(1 + (0.5 * slip / GUST) ** 2)
    assert gust_memory(3.0, 0.5, slip, GUST) == pytest.approx(memory)
    walks = np.concatenate(
        [gust_array(scenario_of(replace_seed(seed)), slip)[:, :3].T for seed in range(SEEDS)]
    )
    step = max(1, round(memory / 0.1))
    kept = math.exp(-0.1 * step / memory)
    products = walks[:, 20] * walks[:, 20 + step] / GUST**2
    assert products.mean() == pytest.approx(kept, abs=4 * math.sqrt((1 + kept**2) / len(walks)))
    # It crosses an eddy of the size u' T / beta in the time that remains.
    assert gust_memory(3.0, 0.5, 1e6, GUST) * 1e6 == pytest.approx(GUST * 3.0 / 0.5, rel=1e-6)


def test_gusts_are_uniform_along_a_body_without_length_and_with_no_crossing():
    assert not gusts_of(3)[:, 6:].any()
    assert not gust_array(scenario_of(GUSTY.model_copy(update={"crossing": 0.0})), 0.3, 0.2)[:, 6:].any()
    alike = gust_array(scenario_of(GUSTY.model_copy(update={"crossing": 0.0})), 0.3, 0.2)
    assert np.array_equal(alike[:, :6], gusts_of(0)[:, :6])


def test_the_shear_of_a_gust_is_that_of_its_rows():
    scenario = scenario_of(GUSTY)
    rows = gust_array(scenario, 0.1, 0.3)
    flow = flow_array(scenario)
    for k in (0, 7, 40):
        assert gust_shear(0.1 * k, flow, rows) == pytest.approx(tuple(rows[k, 6:9]), rel=1e-9)


@pytest.mark.parametrize("lag", [0.1, 1.0, 3.0, 9.0])
def test_gusts_are_forgotten_exponentially_within_their_memory(walks, lag):
    step = round(lag / 0.1)
    products = walks[:, 20] * walks[:, 20 + step] / GUST**2
    kept = math.exp(-lag / 3.0)
    assert products.mean() == pytest.approx(kept, abs=4 * math.sqrt((1 + kept**2) / len(walks)))


def test_the_components_of_gusts_are_independent(walks):
    x, y, z = walks.reshape(SEEDS, 3, -1)[:, :, 100].T / GUST
    for a, b in ((x, y), (y, z), (z, x)):
        assert (a * b).mean() == pytest.approx(0, abs=4 / math.sqrt(SEEDS))


@given(st.floats(0.001, 19.9))
def test_the_rate_of_the_water_is_the_derivative_of_its_velocity(t):
    stream, point, h = Stream(scenario_of(GUSTY)), [4.0, 0.3, 0.2], 1e-5
    velocity, _, rate = stream(point, t)
    before, after = stream.velocity(point, t - h), stream.velocity(point, t + h)
    # The third derivative of a cubic between values 0.1 s apart is bounded, and jumps only there.
    assert (after - before) / (2 * h) == pytest.approx(rate, abs=1e-3)
    assert velocity - stream_of(LogLawFlow(speed=1.0)).velocity(point) == pytest.approx(
        (before + after) / 2 - stream_of(LogLawFlow(speed=1.0)).velocity(point), abs=1e-6
    )


@pytest.mark.parametrize("count", [4, 5, 90])
def test_the_slopes_of_the_spline_are_those_of_scipy(count):
    values = np.random.default_rng(count).standard_normal((count, 6))
    times = 0.1 * np.arange(count)
    np.testing.assert_allclose(
        find_spline_slopes(values, 0.1), CubicSpline(times, values)(times, 1), atol=1e-10
    )


def test_gusts_are_smooth_in_time_and_pass_through_the_walk():
    stream, rows = Stream(scenario_of(GUSTY)), gusts_of(0)
    mean = stream_of(LogLawFlow(speed=1.0)).velocity([1, 0, 0])
    for k in (0, 1, 57, 199):
        velocity, _, rate = stream([1, 0, 0], 0.1 * k)
        assert velocity - mean == pytest.approx(rows[k, :3], abs=1e-12)
        assert rate == pytest.approx(rows[k, 3:6], abs=1e-12)
        for gap in (-1e-9, 1e-9) if k else (1e-9,):
            beside, _, rate_beside = stream([1, 0, 0], 0.1 * k + gap)
            assert beside == pytest.approx(velocity, abs=1e-8)
            assert rate_beside == pytest.approx(rate, abs=1e-6)


def test_a_tracer_spreads_by_16_cm_on_its_way_through_the_pipe():
    # Along the axis, where the mean flow makes 1.136 m/s, 9 m take 8 s. Taylor: the variance of the displacement
    # is 2 u'^2 T (t - T (1 - exp(-t / T))).
    t, memory = np.arange(0, 8.05, 0.1), 3.0
    ends = []
    for seed in range(SEEDS):
        rows = gusts_of(seed)[: len(t)]
        ends.append(CubicHermiteSpline(t, rows[:, :3], rows[:, 3:6]).integrate(0.0, 8.0))
    spread = np.array(ends).std(axis=0, mean=0.0)
    taylor = GUST * math.sqrt(2 * memory * (8.0 - memory * (1 - math.exp(-8.0 / memory))))
    error = 4 / math.sqrt(2 * SEEDS)
    assert spread == pytest.approx([taylor] * 3, rel=error)
    assert math.sqrt((spread**2).mean()) == pytest.approx(0.165, rel=0.02 + error / math.sqrt(3))


def test_a_body_with_drag_meets_gusts_that_differ_along_it_and_one_without_does_not():
    pipeline = load_study("paper", ["hydrodynamics.drag=strips"], use={"simulator": "native"}).make_pipeline()
    agent = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(1)))
    table = {}
    for crossing in (0.0, 0.5):
        flow = GUSTY.model_copy(update={"crossing": crossing})
        model = flight_model(agent, scenario_of(flow))
        table[crossing] = gust_shear(1.3, model.flow, model.gusts)
        slip = terminal_speed_across(
            agent.coefficients.drag, agent.mass.net_buoyancy(Fluid()), 1024.0, 1.05e-6
        )
        expected = gust_array(scenario_of(flow), slip, agent.body.length)
        assert crossing == 0.0 or np.allclose(model.gusts, expected)
    assert table[0.0] == (0.0, 0.0, 0.0)
    assert min(map(abs, table[0.5])) > 0
    ideal = replace(agent, coefficients=replace(agent.coefficients, drag=None))
    assert np.array_equal(flight_model(ideal, scenario_of(GUSTY)).gusts, gusts_of(0))
