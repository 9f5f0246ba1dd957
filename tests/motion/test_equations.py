"""Equations of motion: against Fossen's 6x6 matrices, and in water that accelerates and shears."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from textbook import textbook_rate

from driftform.motion.forces.equations import accelerations, water_motion_at_cob
from driftform.motion.forces.model import flight_model
from driftform.study import load_study
from driftform.testing.agents import DENSITY, GRAVITY, Spheroid, sphere_agent
from driftform.testing.bodies import spheroid_body
from driftform.types import Agent, Coefficients, MassProperties
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import DevelopingFlow, LogLawFlow, PowerLawFlow, TurbulentFlow, UniformFlow
from driftform.water.velocity import ACCELERATION, gust_at, water_motion

STILL = np.zeros(3)
NEUTRAL = DENSITY * 4 / 3 * np.pi * 0.01**3

vectors = st.tuples(*[st.floats(-2, 2)] * 3).map(np.array)
turns = st.tuples(*[st.floats(-3, 3)] * 3).map(lambda turn: Rotation.from_rotvec(turn).as_matrix())


def accelerated(model, R=None, position=STILL, velocity=STILL, omega=STILL, t=0.0):
    """Acceleration of the origin (world) and of rotation (body), (6,)."""
    rows = tuple(tuple(row) for row in (np.eye(3) if R is None else R).tolist())
    position, velocity, omega = (tuple(np.asarray(v, dtype=float).tolist()) for v in (position, velocity, omega))
    return np.concatenate(accelerations(float(t), position, rows, velocity, omega, model))


def pipe_of(radius=100.0, end=(200.0, 0.0, 0.0)):
    return Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=end, radius=radius),))


def scenario_of(flow, mode):
    fluid = Fluid(density=DENSITY, gravity=GRAVITY, flow_force=mode)
    return Scenario(pipe=pipe_of(1.0, (9.0, 0.0, 0.0)), flow=flow, fluid=fluid)


# Against Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), theorem 3.2 and section 8.1.


def random_agent(rng, *, damped):
    """Nothing about it is symmetric but what must be, and every point lies elsewhere."""
    size = np.array([1.0, 1.0, 1.0, 0.06, 0.06, 0.06])
    root = rng.normal(size=(6, 6))
    inertia = rng.normal(size=(3, 3))
    linear, quadratic = damped * rng.normal(size=(2, 6, 6)) * np.outer(size, size)
    return Agent(
        spheroid_body(0.06, 0.02, edges=8),
        MassProperties(
            rng.uniform(0.05, 0.2),
            rng.uniform(-0.01, 0.01, 3),
            1e-4 * (np.eye(3) + 0.2 * inertia @ inertia.T),
            rng.uniform(5e-5, 2e-4),
            rng.uniform(-0.01, 0.01, 3),
        ),
        Coefficients(
            0.03 * size[:, None] * (root @ root.T) * size,
            origin=rng.uniform(-0.02, 0.02, 3),
            linear_damping=0.1 * linear,
            quadratic_damping=0.1 * quadratic,
        ),
    )


@pytest.mark.parametrize("seed", range(50))
def test_accelerations_are_those_of_fossens_matrices(seed):
    rng = np.random.default_rng(seed)
    agent = random_agent(rng, damped=seed % 2)
    turn, velocity, omega = Rotation.random(rng=rng), rng.normal(size=3), rng.normal(0, 10, 3)
    flow, fluid = UniformFlow(speed=rng.uniform(-2, 2)), Fluid(density=DENSITY, gravity=GRAVITY)
    scenario = Scenario(flow=flow, fluid=fluid)
    state = np.concatenate([rng.normal(size=3), turn.as_quat(scalar_first=True), turn.inv().apply(velocity), omega])
    rate = textbook_rate(agent, scenario, state)
    expected = np.concatenate([turn.apply(rate[7:10] + np.cross(omega, state[7:10])), rate[10:]])
    found = accelerated(flight_model(agent, scenario), turn.as_matrix(), state[:3], velocity, omega)
    for half in (slice(0, 3), slice(3, 6)):
        assert found[half] == pytest.approx(expected[half], abs=1e-10 * np.linalg.norm(expected[half]))


# Water that accelerates.


def ramp(agent, acceleration, mode):
    """The agent in water of the velocity acceleration t, in a pipe along it whose walls are far away."""
    scenario = Scenario(
        pipe=pipe_of(), flow=UniformFlow(speed=0.0), fluid=Fluid(density=DENSITY, gravity=GRAVITY, flow_force=mode)
    )
    model = flight_model(agent, scenario)
    numbers, flow = model.numbers.copy(), model.flow.copy()
    numbers["is_steady"] = 0.0
    flow[ACCELERATION] = np.linalg.norm(acceleration)
    axis = np.asarray(acceleration) / flow[ACCELERATION] if flow[ACCELERATION] else np.array([1.0, 0.0, 0.0])
    return model._replace(numbers=numbers, flow=flow, pipe=np.array([[*(-500 * axis), *axis, 1000.0, 100.0]]))


@pytest.mark.parametrize(("mode", "share"), [("full", 1.0), ("paper", 1 / 3)])
def test_a_neutral_sphere_follows_accelerating_water_whole_or_by_a_third(mode, share):
    model = ramp(sphere_agent(0.01, NEUTRAL), [1.0, 0.0, 0.0], mode)
    for t in (0.0, 2.5, 9.0):
        found = accelerated(model, velocity=[t, 0, 0], position=[1.0, 0, 0], t=t)
        assert found == pytest.approx([share, 0, 0, 0, 0, 0], abs=1e-9)


@given(st.floats(1e-3, 0.5), st.floats(0.1, 2.0), vectors, vectors, turns)
def test_a_sphere_is_pushed_by_its_displaced_and_its_added_mass(mass, added, a, velocity, R):
    # Auton, Hunt and Prud'homme: m dv/dt = rho V Du/Dt + k rho V (Du/Dt - dv/dt) + (rho V - m) g.
    for mode, displaced in (("full", NEUTRAL), ("paper", 0.0)):
        model = ramp(sphere_agent(0.01, mass, added=added), a, mode)
        net = (NEUTRAL - mass) * GRAVITY * np.array([0, 0, 1])
        expected = ((displaced + added * NEUTRAL) * a + net) / (mass + added * NEUTRAL)
        found = accelerated(model, R, [2.0, 1.0, -3.0], velocity, t=4.0)
        assert found == pytest.approx([*expected, 0, 0, 0], rel=1e-9, abs=1e-8)


@given(st.integers(0, 10**6), vectors, turns)
def test_a_neutral_body_of_any_shape_stays_with_water_that_accelerates(seed, a, R):
    agent = random_agent(np.random.default_rng(seed), damped=True)
    mass = replace(agent.mass, mass=DENSITY * agent.mass.volume, cog=agent.mass.cob)
    model = ramp(replace(agent, mass=mass), a, "full")
    t = 1.7
    found = accelerated(model, R, [3.0, 0.5, -0.2], t * a, t=t)
    assert found[:3] == pytest.approx(a, abs=1e-9)
    assert found[3:] == pytest.approx(STILL, abs=1e-6)


@given(st.integers(0, 10**6), vectors, vectors, turns)
def test_an_acceleration_of_zero_leaves_uniform_water_steady(seed, velocity, omega, R):
    agent = random_agent(np.random.default_rng(seed), damped=True)
    calm = ramp(agent, STILL, "full")
    for mode in ("full", "paper"):
        steady = flight_model(
            agent,
            Scenario(
                pipe=pipe_of(),
                flow=UniformFlow(speed=0.0),
                fluid=Fluid(density=DENSITY, gravity=GRAVITY, flow_force=mode),
            ),
        )
        assert steady.numbers[0]["is_steady"] == 1.0
        expected = accelerated(steady, R, [3.0, 0.5, -0.2], velocity, omega)
        assert accelerated(calm, R, [3.0, 0.5, -0.2], velocity, omega, 1.0) == pytest.approx(expected, rel=1e-12)


def test_water_that_accelerates_turns_a_body_whose_mass_is_not_where_its_volume_is():
    # In the water's frame the body's own mass feels -m a at the COG: like gravity along -a, with the displaced water
    # as its buoyancy. A neutral body with its COG behind the COB therefore turns as if hung up.
    agent = Spheroid(0.06, 0.02).agent()
    agent = replace(agent, mass=replace(agent.mass, cog=np.array([-0.01, 0.0, 0.0])))
    scenario = Scenario(flow=UniformFlow(speed=0.0), fluid=Fluid(density=DENSITY, gravity=2.0, flow_force="full"))
    hung = flight_model(agent, scenario)
    model = ramp(agent, [0.0, 0.0, 2.0], "full")
    model.numbers["gravity"] = 0.0  # no gravity but that of the moving frame
    R = Rotation.from_rotvec([0.0, 0.4, 0.0]).as_matrix()
    found, expected = accelerated(model, R), accelerated(hung, R)
    assert expected[4] != pytest.approx(0, abs=0.1)
    assert found[3:] == pytest.approx(expected[3:], rel=1e-9)
    assert found[:3] - [0, 0, 2.0] == pytest.approx(expected[:3], abs=1e-9)


# Water that shears.

SHEARED = {
    "power law": PowerLawFlow(speed=1.2),
    "log law": LogLawFlow(speed=1.2),
    "developing": DevelopingFlow(speed=1.2),
}


@cache
def sphere_in(what, mode):
    return flight_model(sphere_agent(0.01, NEUTRAL), scenario_of(SHEARED[what], mode))


def change_along(model, point, velocity, h=1e-5):
    """Change of the water's velocity for who moves with ``velocity``, by differences along the way, m/s2."""
    ends = [
        np.array(water_motion(tuple((point + s * h * velocity).tolist()), 0.0, model.pipe, model.flow)[0])
        for s in (1, -1)
    ]
    return (ends[0] - ends[1]) / (2 * h)


places = st.tuples(st.floats(0.5, 8.5), st.floats(0.05, 0.8), st.floats(0, 2 * np.pi)).map(
    lambda p: np.array([p[0], p[1] * np.cos(p[2]), p[1] * np.sin(p[2])])
)


@given(st.sampled_from(list(SHEARED)), places, vectors)
def test_a_neutral_sphere_that_crosses_shear_follows_the_waters_own_acceleration_or_a_third_of_its_change(
    what, place, velocity
):
    """With the pressure of the water, the water's change along its own path; without it, a third of that along the sphere's."""
    for mode in ("full", "paper"):
        model = sphere_in(what, mode)
        stream = np.array(water_motion(tuple(place.tolist()), 0.0, model.pipe, model.flow)[0])
        path, share = (stream, 1.0) if mode == "full" else (velocity, 1 / 3)
        # The change downstream of developing flow's radial velocity is left out of the gradient: 1e-3 1/s at most.
        slack = 1e-6 + (what == "developing") * 2e-3 * abs(path[0])
        change = change_along(model, place, path)
        if mode == "full" and what != "developing":
            assert change == pytest.approx(STILL, abs=1e-6), "parallel flow does not accelerate along its own path"
        found = accelerated(model, position=place, velocity=velocity)
        assert found == pytest.approx([*share * change, 0, 0, 0], abs=slack)


@given(places, vectors, st.floats(0.1, 9.0), vectors)
def test_gusty_water_accelerates_as_its_gust_and_its_mean_flow_change_along_its_path(place, velocity, tau, drift):
    agent = sphere_agent(0.01, NEUTRAL)
    for mode, share in (("full", 1.0), ("paper", 1 / 3)):
        model = flight_model(agent, scenario_of(TurbulentFlow(speed=1.2), mode))
        point = tuple(place.tolist())
        mean, gradient, _ = water_motion(point, 0.0, model.pipe, model.flow)
        model.eddies[0] = tau, *(0.1 * drift)
        gust, rate, _ = gust_at(point, mean, model.pipe, model.flow, model.gusts, model.eddies)
        path = np.array(mean) + gust if mode == "full" else velocity
        change = np.array(rate) + np.array(gradient) @ path
        found = accelerated(model, position=place, velocity=velocity)
        assert found == pytest.approx([*share * change, 0, 0, 0], rel=1e-9, abs=1e-9)


@given(st.sampled_from(list(SHEARED)), places, vectors, vectors, turns)
def test_the_water_is_that_at_the_centre_of_buoyancy(what, place, velocity, omega, R):
    agent = sphere_agent(0.01, NEUTRAL)
    centre = np.array([0.02, -0.01, 0.015])
    agent = replace(agent, mass=replace(agent.mass, cob=centre))
    rows = tuple(tuple(row) for row in R.tolist())
    where = tuple((place - R @ centre).tolist())
    for mode in ("full", "paper"):
        model = flight_model(agent, scenario_of(SHEARED[what], mode))
        there = water_motion(tuple(place.tolist()), 0.0, model.pipe, model.flow)
        stream, change, shear, curl = water_motion_at_cob(
            0.0, where, rows, tuple(velocity.tolist()), tuple(omega.tolist()), model
        )
        path = np.array(there[0]) if mode == "full" else velocity + R @ np.cross(omega, centre)
        assert stream == pytest.approx(there[0], rel=1e-9, abs=1e-12)
        assert change == pytest.approx(np.array(there[1]) @ path, rel=1e-6, abs=1e-9)
        # Along the axis of the body, in its frame.
        slack = 1e-6 + (what == "developing") * 2e-3
        along = change_along(model, place, R[:, 0])
        assert shear == pytest.approx(R.T @ along, abs=slack)
        gradient = np.column_stack([change_along(model, place, axis) for axis in np.eye(3)])
        spin = [gradient[2, 1] - gradient[1, 2], gradient[0, 2] - gradient[2, 0], gradient[1, 0] - gradient[0, 1]]
        assert curl == pytest.approx(R.T @ spin, abs=2 * slack)


# What stays in its plane.


@pytest.mark.parametrize("name", ["paper", "pipe-inspection"])
def test_a_flight_that_is_released_in_the_vertical_plane_stays_there_exactly(name):
    pipeline = load_study(name, ["fluid.water_level=0.8"], use={"simulator": "native"}).make_pipeline()
    rng = np.random.default_rng(2)
    flights = pipeline.fly([pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(4)])
    assert any(flight.contact is not None for flight in flights)
    for flight in flights:
        assert not flight.position[:, 1].any(), "it is pushed sideways"
        assert not flight.quaternion[:, [1, 3]].any(), "it rolls or yaws"
