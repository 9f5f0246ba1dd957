"""What is made of raw samples: the end at the outlet, the first contact, the drift of the energy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from driftform.agent import mass_properties
from driftform.motion.forces.model import flight_model
from driftform.motion.forces.state import release_state
from driftform.motion.path.trajectory import finish_trajectory
from driftform.motion.solver.error import Accuracy, integrate
from driftform.testing.agents import DENSITY, GRAVITY, Spheroid, sphere_agent, tumbling_agent
from driftform.testing.bodies import cylinder_body
from driftform.types import Agent, Coefficients, Drag, End
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.field import water_velocity
from driftform.water.flow import LogLawFlow, TurbulentFlow, UniformFlow
from driftform.water.scenario import Contact, FlightLimits, Release

NEUTRAL = DENSITY * 4 / 3 * np.pi * 0.01**3
TIGHT = Accuracy(position=math.inf, tolerance=1e-10, tightest=1e-11)


def scenario_of(horizon, *, radius=None, end=(9.0, 0.0, 0.0), flow=None, level=None, gravity=GRAVITY, **release):
    segments = (Segment(start=(0, 0, 0), end=end, radius=radius),) if radius else ()
    return Scenario(
        pipe=Pipe(segments=segments),
        flow=flow or UniformFlow(speed=0.0),
        fluid=Fluid(density=DENSITY, gravity=gravity, water_level=level),
        release=Release(**release),
        contact=Contact(),
        flight=FlightLimits(horizon=horizon),
    )


def flown(agent, scenario, accuracy=TIGHT):
    """The trajectory, and the raw samples and the model that it was made of."""
    model, horizon = flight_model(agent, scenario), scenario.flight.horizon
    raw = integrate(model, release_state(model, scenario), horizon, accuracy)
    trajectory = finish_trajectory(raw.samples, model, horizon, accuracy.step_limit, raw.error, accuracy.position)
    return trajectory, raw.samples, model


# Where a flight ends.


def test_a_fall_through_a_shaft_ends_when_it_has_fallen_so_far():
    # From rest with a constant acceleration, so that the cubic between two samples is the motion itself.
    acceleration = (0.05 - NEUTRAL) * GRAVITY / (0.05 + NEUTRAL / 2)
    scenario = scenario_of(5.0, radius=1.0, end=(0.0, 0.0, -3.0))
    for accuracy in (TIGHT, Accuracy(max_step=0.2)):
        trajectory, samples, _ = flown(sphere_agent(0.01, 0.05), scenario, accuracy)
        assert trajectory.end == End.OUTLET
        assert trajectory.t[-1] == pytest.approx(math.sqrt(6.0 / acceleration), abs=1e-9)
        assert trajectory.position[-1] == pytest.approx([0, 0, -3.0], abs=1e-9)
        assert trajectory.velocity[-1, 0] == pytest.approx(acceleration * trajectory.t[-1], rel=1e-9)
        assert samples[-1, 3] < -3.0 <= samples[-2, 3]
        assert len(trajectory.t) == len(samples)


def test_a_flight_that_is_not_accurate_enough_has_failed_and_tells_its_error():
    scenario = scenario_of(0.5)
    _, samples, model = flown(sphere_agent(0.01, 0.05), scenario)
    for error, accepted, end in (
        (1e-3, 1e-2, End.HORIZON),
        (1e-3, 1e-4, End.NOT_CONVERGED),
        (math.inf, 1e-4, End.NOT_CONVERGED),
        (math.nan, 1e-4, End.NOT_CONVERGED),
        (None, 1e-4, End.HORIZON),
    ):
        trajectory = finish_trajectory(samples, model, 0.5, 10**6, error, accepted)
        assert trajectory.end == end
        assert trajectory.end.failed == (end == End.NOT_CONVERGED)
        assert trajectory.error is error or trajectory.error == error


def test_a_flight_that_did_not_converge_has_what_two_integrations_agree_on():
    scenario = scenario_of(0.5)
    _, samples, model = flown(sphere_agent(0.01, 0.05), scenario)
    other, parting = samples.copy(), 0.3
    later = np.maximum(0.0, other[:, 0] - parting)
    other[:, 1] += 0.5 * later**2
    other[:, 8] += later
    cut = finish_trajectory(samples, model, 0.5, 10**6, 1.0, 1e-3, other)
    whole = finish_trajectory(samples, model, 0.5, 10**6)
    assert cut.end == End.NOT_CONVERGED
    assert (cut.position == whole.position[: len(cut.t)]).all()
    # .5 t^2 is a millimetre after 45 ms.
    assert cut.t[-1] <= parting + math.sqrt(2e-3) < whole.t[len(cut.t)]
    assert len(finish_trajectory(samples, model, 0.5, 10**6, 1.0, 1e-3, other[:1]).t) == 1


@pytest.mark.parametrize("flow", [LogLawFlow(speed=0.8), TurbulentFlow(speed=0.8)])
def test_a_body_released_with_the_current_has_the_velocity_of_the_water_there(flow):
    scenario = scenario_of(1.0, radius=1.0, flow=flow, position=(0.0, 0.0, 0.7))
    model = flight_model(sphere_agent(0.01, 0.05), scenario)
    velocity = water_velocity([0.0, 0.0, 0.7], 0.0, scenario, gusts=True)[0]
    assert release_state(model, scenario)[7:10] == pytest.approx(velocity, rel=1e-3)
    assert abs(velocity[0] - 0.8) > 1e-3


# When a wall is first touched.


def reach_beyond(agent, rows, radius):
    """How far the body reaches beyond the wall at each sample, m, negative where it is clear of it."""
    angles = np.linspace(0, 2 * np.pi, 181)
    R = Rotation.from_quat(rows[:, 4:8], scalar_first=True).as_matrix()
    deepest = np.full(len(rows), -np.inf)
    for x, r in agent.body.outer:
        ring = np.stack([np.full_like(angles, x), r * np.cos(angles), r * np.sin(angles)])
        across = rows[:, 2:4, None] + R[:, 1:] @ ring
        deepest = np.maximum(deepest, np.linalg.norm(across, axis=1).max(axis=1) - radius)
    return deepest


@pytest.mark.parametrize("pitch", [0.0, 25.0])
def test_a_tumbling_body_touches_when_a_fine_search_finds_it(pitch):
    agent, radius = tumbling_agent(), 0.15
    scenario = scenario_of(2.0, radius=radius, velocity=(0.8, 0.1, 0.15), pitch_deg=pitch, flow=UniformFlow(speed=1.0))
    _, fine, _ = flown(agent, scenario, Accuracy(position=math.inf, tolerance=1e-11, max_step=5e-4))
    depth = reach_beyond(agent, fine, radius)
    k = int(np.argmax(depth > 0))
    assert 0 < k < len(fine) - 1
    # Between two samples half a millisecond apart it goes linearly into the wall.
    share = -depth[k - 1] / (depth[k] - depth[k - 1])
    expected = fine[k - 1, 0] + share * (fine[k, 0] - fine[k - 1, 0])
    speed = (depth[k] - depth[k - 1]) / (fine[k, 0] - fine[k - 1, 0])
    trajectory, *_ = flown(agent, scenario, Accuracy(position=math.inf, tolerance=1e-9))
    # The rim of a blunt body touches with up to 1e-3 of its radius less; a bore that falls away takes as little.
    slack = 1e-3 * 0.02 / speed + 1e-5
    assert trajectory.contact == pytest.approx(expected, abs=slack)


def test_a_flight_that_starts_in_the_wall_touches_at_once_and_one_that_stays_clear_never():
    sunk = scenario_of(0.3, radius=0.2, position=(0.0, 0.0, 0.195))
    trajectory, _, _ = flown(sphere_agent(0.01, NEUTRAL), sunk)
    assert trajectory.contact == 0.0
    assert trajectory.energy_drift is None, "there is nothing before the contact"
    clear, _, _ = flown(sphere_agent(0.01, NEUTRAL), scenario_of(0.3, radius=0.2, velocity=(1.0, 0.0, 0.4)))
    assert clear.contact is None


def test_past_the_outlet_no_wall_is_touched():
    # It would touch at 0.38 s, and is out at 0.3 s.
    scenario = scenario_of(0.8, radius=0.2, end=(0.3, 0.0, 0.0), velocity=(1.0, 0.0, 0.5))
    trajectory, _, _ = flown(sphere_agent(0.01, NEUTRAL), scenario)
    assert trajectory.end == End.OUTLET
    assert trajectory.contact is None


# How the energy drifts.


def with_drag(drag):
    agent = tumbling_agent()
    return replace(agent, coefficients=replace(agent.coefficients, drag=drag))


def test_the_energy_of_a_tumbling_body_is_kept_in_still_and_in_moving_water():
    for speed, end in ((0.0, (9.0, 0.0, 0.0)), (1.0, (9.0, 0.0, 0.0)), (1.0, (6.0, 2.0, -6.0))):
        scenario = scenario_of(
            2.0, radius=20.0, end=end, flow=UniformFlow(speed=speed), velocity=(speed + 0.5, 0.2, -0.1), pitch_deg=20.0
        )
        trajectory, _, _ = flown(tumbling_agent(), scenario)
        assert trajectory.energy_drift < 1e-6


def test_the_drift_of_the_energy_is_what_a_false_step_adds():
    scenario = scenario_of(1.0, gravity=0.0, velocity=(0.5, 0.0, 0.0))
    _, samples, model = flown(sphere_agent(0.01, NEUTRAL), scenario)
    samples[-1, 8] *= 1.01
    drift = finish_trajectory(samples, model, 1.0, 10**6).energy_drift
    assert drift == pytest.approx((1.01**2 - 1) / 1.01**2, rel=1e-6)


@pytest.mark.parametrize("gravity", [0.0, GRAVITY])
@pytest.mark.parametrize("heavier", [0.0, 1e-15])
def test_rounding_is_no_drift_of_a_body_that_does_not_move_in_the_water(gravity, heavier):
    agent = Spheroid(0.06, 0.01).agent()
    agent = replace(agent, mass=replace(agent.mass, mass=(1 + heavier) * agent.mass.mass))
    for speed, pitch, height in ((0.0, 20.0, 0.3), (1.0, 20.0, 0.0), (1.0, 0.0, -5.0)):
        scenario = scenario_of(
            2.0, gravity=gravity, flow=UniformFlow(speed=speed), pitch_deg=pitch, position=(0.0, 0.0, height)
        )
        assert flown(agent, scenario)[0].energy_drift < 1e-6


def test_energy_drifts_up_to_the_contact_only():
    scenario = scenario_of(2.0, radius=0.2, velocity=(0.8, 0.0, 0.5), flow=UniformFlow(speed=1.0), pitch_deg=-20.0)
    trajectory, _, _ = flown(Spheroid(0.06, 0.01).agent(), scenario)
    assert trajectory.contact is not None
    assert trajectory.energy_drift < 1e-6, "the wall takes energy, and that is no drift"


@pytest.mark.parametrize(
    ("agent", "flow"),
    [
        (tumbling_agent(damped=True), UniformFlow(speed=1.0)),
        (with_drag(Drag(np.array([[0.0, 0.02, 0.1, 1.0]]))), UniformFlow(speed=1.0)),
        (with_drag(Drag(np.empty((0, 4)), ahead=1e-4)), UniformFlow(speed=1.0)),
        (tumbling_agent(), LogLawFlow(speed=1.0)),
        (tumbling_agent(), TurbulentFlow(speed=1.0)),
    ],
    ids=["damping", "drag", "axial drag", "shear", "gusts"],
)
def test_where_nothing_keeps_the_energy_there_is_no_drift_to_tell(agent, flow):
    trajectory, _, _ = flown(agent, scenario_of(0.2, radius=1.0, flow=flow), Accuracy())
    assert trajectory.energy_drift is None


def test_a_current_that_carries_a_body_up_to_the_surface_does_work_on_it():
    release = {"velocity": (0.5, 0.0, 0.0), "radius": 1.0, "level": 0.02}
    sloped = scenario_of(0.5, end=(9.0, 0.0, 3.0), flow=UniformFlow(speed=0.5), **release)
    assert flown(tumbling_agent(), sloped)[0].energy_drift is None
    for still in (
        scenario_of(0.5, end=(9.0, 0.0, 3.0), **release),
        scenario_of(0.5, flow=UniformFlow(speed=0.5), **release),
    ):
        assert flown(tumbling_agent(), still)[0].energy_drift < 1e-6


def floater(share, length=0.12, radius=0.02, cog=0.0):
    """A cylinder with a share of the density of water, and its centre of gravity so far fore (m)."""
    body = cylinder_body(length, radius)
    mass = mass_properties(body)
    m = share * DENSITY * mass.volume
    inertia = m * np.diag([radius**2 / 2, *[(3 * radius**2 + length**2) / 12] * 2])
    properties = replace(mass, mass=m, inertia=inertia, cog=np.array([cog, 0.0, 0.0]))
    added = DENSITY * mass.volume * np.diag([0.1, 0.85, 0.85, 0.0, 8e-4, 8e-4])
    return Agent(body, properties, Coefficients(added))


@pytest.mark.parametrize(
    ("agent", "release"),
    [
        (floater(0.5), {"position": (0.0, 0.0, 0.005)}),
        (floater(0.5, cog=0.01), {"position": (0.0, 0.0, 0.03), "pitch_deg": 20.0}),
        (floater(0.4, cog=-0.04), {"position": (0.0, 0.0, 0.1), "pitch_deg": 80.0}),
        (tumbling_agent(), {"position": (0.0, 0.0, 0.0), "velocity": (0.3, 0.1, 0.5)}),
    ],
    ids=["level", "pitching", "upright", "tumbling"],
)
def test_a_bobbing_body_keeps_its_energy(agent, release):
    scenario = scenario_of(3.0, level=0.0, **release)
    accuracy = Accuracy(position=math.inf, tolerance=1e-9, tightest=1e-12, max_step=0.01)
    trajectory, _, _ = flown(agent, scenario, accuracy)
    assert trajectory.end == End.HORIZON
    height = trajectory.position[:, 2]
    assert height.min() < -1e-3, "it is meant to go down"
    assert height.max() > 1e-3, "and up"
    assert trajectory.energy_drift < 1e-6
