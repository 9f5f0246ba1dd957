"""Contract of simulators: motions with a known solution, the ends of a flight, contact, and failures."""

import math
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import resources
from typing import Any, ClassVar

import numpy as np
import pytest

from driftform.interfaces import Simulator
from driftform.motion import forces, path, solver
from driftform.motion.path.curve import world_velocity
from driftform.motion.path.interpolation import interpolate_positions
from driftform.plugins.seams import require_flights
from driftform.testing.agents import DENSITY, GRAVITY, Spheroid, sphere_agent, straight_pipe, tumbling_agent
from driftform.testing.bodies import spheroid_body
from driftform.testing.contract import AnsweringContract, Question
from driftform.types import Agent, Coefficients, Drag, End, FloatArray, Trajectory, same_content
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import PowerLawFlow, TurbulentFlow, UniformFlow
from driftform.water.pipe import Vector
from driftform.water.scenario import Contact, FlightLimits, Release

SPHEROID = Spheroid(0.06, 0.01)
"""A neutral spheroid, 120 mm long and 20 mm thick."""

RADIUS = 0.01
NEUTRAL_MASS = DENSITY * 4 / 3 * math.pi * RADIUS**3
NEUTRAL = sphere_agent(RADIUS, NEUTRAL_MASS)
"""A neutral sphere, 20 mm thick."""

HEAVY = sphere_agent(RADIUS, 0.05)
"""A sphere that falls with (m - rho V) g / (m + rho V / 2)."""


def water_scenario(
    horizon: float,
    velocity: str | Vector = "current",
    *,
    speed: float = 0.0,
    pitch_deg: float = 0.0,
    position: Vector = (0.0, 0.0, 0.0),
    gravity: float = GRAVITY,
    pipe: tuple[float, float] | None = None,
    restitution: float = 0.25,
    **tables: Any,
) -> Scenario:
    """Return a scenario with a current of ``speed`` (m/s) along x, in open water or in a ``pipe`` of (length, radius), m.

    ``tables``, such as ``flow``, take the place of those that the other arguments make.
    """
    return Scenario(
        pipe=straight_pipe(*pipe) if pipe else Pipe(segments=()),
        flow=UniformFlow(speed=speed),
        fluid=Fluid(density=DENSITY, gravity=gravity),
        release=Release.model_validate({"position": position, "pitch_deg": pitch_deg, "velocity": velocity}),
        contact=Contact(restitution=restitution),
        flight=FlightLimits(horizon=horizon),
    ).model_copy(update=tables)


NOT_FINITE: dict[str, Callable[[], Agent]] = {
    "an added mass that is not a number": lambda: replace(HEAVY, coefficients=Coefficients(np.full((6, 6), np.nan))),
    "a centre of gravity that is not a number": lambda: replace(
        HEAVY, mass=replace(HEAVY.mass, cog=np.full(3, np.nan))
    ),
    "an infinite volume": lambda: replace(HEAVY, mass=replace(HEAVY.mass, volume=math.inf)),
    "damping that feeds the motion": lambda: replace(
        HEAVY, coefficients=replace(HEAVY.coefficients, linear_damping=-1e3 * np.eye(6))
    ),
}


MOTIONS = tomllib.loads(resources.files(__package__).joinpath("motions.toml").read_text("utf-8"))
"""Agents and tables of scenarios by the name of a motion."""

REFERENCE = 5e-10
"""Error of the flights of the core that others are compared with, m."""


def make_motion(name: str) -> tuple[Agent, Scenario]:
    """Return agent and scenario of one of the motions."""
    tables = {"fluid": {}, "flow": {}, "release": {}} | MOTIONS[name]
    given = {"density": DENSITY, "gravity": GRAVITY, "kind": "uniform", "speed": 0.0, "velocity": "current"}
    for table, keys in (("fluid", ("density", "gravity")), ("flow", ("kind", "speed")), ("release", ("velocity",))):
        tables[table] = {key: given[key] for key in keys} | tables[table]
    return make_known_agent(tables.pop("agent")), Scenario.model_validate(tables)


def make_known_agent(name: str) -> Agent:
    """Return an agent of the motions by its name."""
    spheroid, masses = (SPHEROID.agent(), {"buoyant spheroid": 0.5, "heavy spheroid": 1.5, "spheroid with strips": 1.2})
    if name in masses:
        spheroid = replace(spheroid, mass=replace(spheroid.mass, mass=masses[name] * SPHEROID.mass))
    match name:
        case "tumbling" | "damped":
            return tumbling_agent(damped=name == "damped")
        case "buoyant spheroid":
            # So few edges that only the widest rim touches.
            return replace(spheroid, body=spheroid_body(SPHEROID.a, SPHEROID.b, edges=4))
        case "spheroid with strips":
            strips = np.array([[x, 0.02, 0.05, 1.0] for x in np.linspace(-0.125, 0.125, 6)])
            drag = Drag(strips, creeping=(0.0, 40.0, 0.0, 0.0))
            return replace(spheroid, coefficients=replace(spheroid.coefficients, drag=drag))
        case "sphere with linear damping":
            damping = np.diag([3 * NEUTRAL_MASS] * 3 + [0.0] * 3)
            return replace(NEUTRAL, coefficients=replace(NEUTRAL.coefficients, linear_damping=damping))
    spheres = {
        "neutral sphere": NEUTRAL,
        "heavy sphere": HEAVY,
        "massless sphere": sphere_agent(RADIUS, 0.0),
        "sphere with drag": sphere_agent(RADIUS, 0.05, drag=0.47),
        "floating sphere": sphere_agent(0.05, 0.5 * DENSITY * 4 / 3 * math.pi * 0.05**3),
    }
    return spheres.get(name, spheroid)


class PointSimulatorContract(AnsweringContract[Simulator[Any]]):
    """The contract of simulators of points, which know neither attitude nor inertia: neutral bodies drift with the water.

    Inherit this class as :class:`SimulatorContract`. It asks where a flight begins and ends, in straight pipes, bends and
    tees, that the water carries a neutral body, which way others go, and that flights can be repeated.
    """

    def questions(self) -> Sequence[Question]:
        """Return flights with and without a wall, of agents that turn and that do not."""
        scenario = water_scenario(1.5, (1.0, 0.2, 0.3), speed=1.0, pitch_deg=10.0, pipe=(9.0, 0.3))
        agents = (tumbling_agent(damped=True), tumbling_agent(), SPHEROID.agent())
        return [*(("simulate", agent, scenario) for agent in agents), ("simulate", HEAVY, water_scenario(0.5))]

    def fly(self, agent: Agent, scenario: Scenario, end: End | None = End.HORIZON) -> Trajectory:
        """Return the trajectory of a flight that must have this end; ``None`` allows any."""
        simulator = self.plugin()
        [trajectory] = require_flights([simulator.simulate(agent, scenario)], 1, simulator, "simulate")
        assert end in (None, trajectory.end)
        if end is End.HORIZON:
            assert trajectory.t[-1] == pytest.approx(scenario.flight.horizon, rel=1e-9)
        return trajectory

    def test_a_flight_starts_at_its_release(self) -> None:
        """The first sample is the release: time 0, and its position."""
        trajectory = self.fly(NEUTRAL, water_scenario(0.5, speed=1.0, position=(0.1, 0.2, 0.3)))
        assert trajectory.t[0] == 0.0
        np.testing.assert_allclose(trajectory.position[0], (0.1, 0.2, 0.3), atol=1e-12)

    def test_a_flight_follows_a_bend_to_the_outlet(self) -> None:
        """A neutral sphere on the axis ends in the plane of the outlet after a bend of 90 degrees, and not beyond its wall."""
        parts: list[dict[str, Any]] = [{"length": 0.5}, {"kind": "bend", "radius": 0.3}, {"length": 0.4}]
        trajectory = self.fly(NEUTRAL, _parts_scenario(parts), End.OUTLET)
        # The axis turns from x to z: 0.5 m, a quarter of a circle of 0.3 m, and 0.4 m.
        assert trajectory.position[-1, 2] == pytest.approx(0.3 + 0.4, abs=1e-6)
        assert abs(trajectory.position[-1, 0] - (0.5 + 0.3)) < 0.1
        assert trajectory.t[-1] < 2 * (0.5 + 0.5 * math.pi * 0.3 + 0.4) / 0.5

    def test_a_flight_through_a_tee_ends_at_one_of_its_outlets(self) -> None:
        """Bodies released on both sides of the dividing surface leave by the branch and by the run, each in its plane."""
        tee = {
            "kind": "tee",
            "branch_radius": 0.05,
            "fillet": 0.01,
            "share": 0.5,
            "branch": [{"length": 0.4, "outlet": "branch"}],
        }
        parts: list[dict[str, Any]] = [{"length": 0.6}, tee, {"length": 0.4, "outlet": "run"}]
        ends = []
        for height in (-0.06, 0.06):
            scenario = _parts_scenario(parts, position=(0.1, 0.0, height))
            trajectory = self.fly(NEUTRAL, scenario, End.OUTLET)
            assert trajectory.t[-1] < scenario.flight.horizon / 2
            ends.append(trajectory.position[-1])
        by_run, by_branch = ends
        assert by_run[0] > 1.0 and abs(by_run[2]) < 0.1
        assert by_branch[2] > 0.3

    def fly_in_steps(self, agent: Agent, scenario: Scenario, count: int) -> Trajectory:
        """Return the last of ``count`` equal steps of a flight, whose times are since the release."""
        simulator, duration = self.plugin(), scenario.flight.horizon / count
        flown = self.fly(agent, scenario.model_copy(update={"flight": FlightLimits(horizon=duration)}))
        for _ in range(count - 1):
            before, flown = flown, simulator.step(agent, scenario, flown, duration)
            assert flown.t[0] == before.t[-1] and flown.end is End.HORIZON
        assert flown.t[-1] == pytest.approx(scenario.flight.horizon, rel=1e-9)
        return flown

    def test_steps_carry_a_neutral_body_as_one_flight_does(self) -> None:
        """Ten steps of 50 ms in a cross current end 0.5 m downstream of the release."""
        flown = self.fly_in_steps(NEUTRAL, water_scenario(0.5, flow=UniformFlow(speed=1.0, added=(0.0, 0.2, -0.1))), 10)
        np.testing.assert_allclose(flown.position[-1], (0.5, 0.1, -0.05), atol=1e-6)

    def test_samples_are_finite_and_in_order(self) -> None:
        """Times increase strictly, quaternions have unit length, and all values are finite."""
        trajectory = self.fly(tumbling_agent(), water_scenario(1.0, (0.4, 0.3, -0.2)))
        assert (np.diff(trajectory.t) > 0).all()
        np.testing.assert_allclose(np.linalg.norm(trajectory.quaternion, axis=1), 1, atol=1e-12)
        _assert_finite(trajectory)

    def test_velocity_is_the_rate_of_position_over_ground(self) -> None:
        """The velocity, turned into the world frame, is the time derivative of the position."""
        trajectory = self.fly(tumbling_agent(), water_scenario(1.0, (0.4, 0.3, -0.2), speed=1.0))
        world = world_velocity(trajectory)
        # Simpson's rule would need the velocity half-way, which the Hermite curve lacks. The error of the trapezoid
        # is h^3 a' / 12, where a' is a few times 100 m/s3 here.
        h = np.diff(trajectory.t)[:, None]
        slope = np.diff(trajectory.position, axis=0) / h
        np.testing.assert_allclose(slope, 0.5 * (world[:-1] + world[1:]), atol=1000 * h.max() ** 2 / 12)

    def test_a_body_released_with_the_current_drifts_with_it(self) -> None:
        """A neutral body with ``release.velocity = "current"`` drifts with the water and never turns."""
        trajectory = self.fly(SPHEROID.agent(), water_scenario(3.0, speed=0.7))
        np.testing.assert_allclose(trajectory.position[:, 0], 0.7 * trajectory.t, atol=1e-9)
        np.testing.assert_allclose(trajectory.velocity - [0.7, 0, 0, 0, 0, 0], 0, atol=1e-9)

    def test_a_neutral_sphere_is_carried_by_the_profile_where_it_is(self) -> None:
        """On the axis of a pipe the power law with n = 7 is 120/98 of the bulk velocity."""
        scenario = water_scenario(3.0, pipe=(9.0, 1.0), flow=PowerLawFlow(speed=0.8, exponent=7.0))
        trajectory = self.fly(NEUTRAL, scenario)
        np.testing.assert_allclose(trajectory.position[:, 0], 0.8 * 120 / 98 * trajectory.t, atol=1e-6)

    def test_a_flight_ends_exactly_at_the_outlet(self) -> None:
        """The last sample lies in the outlet's plane, which is perpendicular to a pipe in any direction, and none beyond."""
        for end in ((3.0, 0.0, 0.0), (2.0, 3.0, -1.0)):
            length = math.hypot(*end)
            pipe = Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=end, radius=0.5),))
            scenario = water_scenario(20.0, speed=0.83).model_copy(update={"pipe": pipe})
            trajectory = self.fly(NEUTRAL, scenario, End.OUTLET)
            np.testing.assert_allclose(trajectory.position[-1], end, atol=1e-9)
            assert trajectory.t[-1] == pytest.approx(length / 0.83, abs=1e-9)
            assert (trajectory.position[:-1] @ end < length**2).all()

    def test_a_flight_that_does_not_arrive_ends_at_the_horizon(self) -> None:
        """The flight ends exactly at that time, wherever the agent is."""
        trajectory = self.fly(NEUTRAL, water_scenario(1.234, speed=1.0, pipe=(9.0, 1.0)))
        assert trajectory.t[-1] == pytest.approx(1.234, abs=1e-9)
        assert trajectory.position[-1, 0] == pytest.approx(1.234, abs=1e-9)

    @pytest.mark.parametrize("what", NOT_FINITE)
    def test_an_impossible_agent_gives_finite_samples_instead_of_an_exception(self, what: str) -> None:
        """The trajectory holds finite samples, at least the release; the flight may fail, or need none of what is impossible."""
        trajectory = self.plugin().simulate(NOT_FINITE[what](), water_scenario(1.0, speed=1.0, pipe=(9.0, 1.0)))
        assert len(trajectory.t) >= 1 and trajectory.t[0] == 0.0
        _assert_finite(trajectory)

    def test_a_batch_is_exactly_its_single_flights(self) -> None:
        """Every flight of a batch equals the flight of its agent alone to the last bit, whatever the other agents."""
        broken = NOT_FINITE["an added mass that is not a number"]()
        agents = [tumbling_agent(), HEAVY, broken, SPHEROID.agent()]
        scenarios = [_narrow_scenario()] * len(agents)
        simulator = self.plugin()
        flights = simulator.simulate_batch(agents, scenarios)
        assert len(flights) == len(agents)
        back = simulator.simulate_batch(agents[::-1], scenarios)[::-1]
        for agent, trajectory, reverse in zip(agents, flights, back, strict=True):
            assert same_content(trajectory, simulator.simulate(agent, scenarios[0]))
            assert same_content(trajectory, reverse)
        assert simulator.simulate_batch([], []) == []

    def test_a_screened_flight_that_matters_is_the_simulated_one(self) -> None:
        """Flights that matter equal those of ``simulate`` to the last bit, with their estimated error."""
        agents, scenario = [tumbling_agent(), HEAVY, SPHEROID.agent()], _narrow_scenario()
        simulator = self.plugin()
        flights = simulator.screen_batch(agents, [scenario] * len(agents), lambda index, _: index != 1)
        for index in (0, 2):
            assert same_content(flights[index], simulator.simulate(agents[index], scenario))

    def test_a_screened_flight_that_does_not_matter_is_unchecked_or_the_simulated_one(self) -> None:
        """It is the flight that ``matters`` received first with the agent's index, whose error is ``None``; or it is checked."""
        agents, scenario = [tumbling_agent(), HEAVY, SPHEROID.agent()], _narrow_scenario()
        simulator = self.plugin()
        seen: dict[int, Trajectory] = {}

        def matters(index: int, trajectory: Trajectory) -> bool:
            assert trajectory.error is None
            seen[index] = trajectory
            return False

        flights = simulator.screen_batch(agents, [scenario] * len(agents), matters)
        assert len(flights) == len(agents)
        for index, (agent, flight) in enumerate(zip(agents, flights, strict=True)):
            checked = simulator.simulate(agent, scenario)
            assert same_content(flight, seen.get(index, checked))
            # The same flight, though nothing says how accurate it is.
            times = np.linspace(0.0, min(float(flight.t[-1]), float(checked.t[-1])), 101)
            paths = (interpolate_positions(flight, times), interpolate_positions(checked, times))
            assert largest_distance(*paths) < 0.05
        assert simulator.screen_batch([], [], matters) == []

    @pytest.mark.parametrize(("density", "way"), [(0.8, 1), (1.25, -1)])
    def test_a_buoyant_body_rises_and_a_heavy_one_sinks(self, density: float, way: int) -> None:
        """In still water a sphere of 0.8 times the density of water has risen after 0.2 s, one of 1.25 times has sunk."""
        sphere = sphere_agent(RADIUS, density * NEUTRAL_MASS, drag=0.47)
        trajectory = self.fly(sphere, water_scenario(0.2))
        assert way * trajectory.position[-1, 2] > 1e-3
        np.testing.assert_allclose(trajectory.position[:, :2], 0, atol=1e-6)

    @pytest.mark.parametrize("density", [1.0, 1.25])
    def test_the_estimated_error_covers_what_short_steps_change(self, density: float) -> None:
        """Through a bend, a flight in a hundred steps ends within three times the claimed error, where there is one."""
        parts: list[dict[str, Any]] = [{"length": 0.3}, {"kind": "bend", "radius": 0.3}, {"length": 0.4}]
        sphere = sphere_agent(RADIUS, density * NEUTRAL_MASS, drag=0.47)
        scenario = _parts_scenario(parts, position=(0.1, 0.0, 0.06)).model_copy(
            update={"flight": FlightLimits(horizon=1.0)}
        )
        whole, flown = self.fly(sphere, scenario), self.fly_in_steps(sphere, scenario, 100)
        apart = largest_distance(flown.position[-1:], whole.position[-1:])
        assert whole.error is None or apart <= 3 * whole.error + 1e-6


class SimulatorContract(PointSimulatorContract):
    """The contract of simulators of rigid bodies.

    Attributes:
        drift: greatest change of energy and impulse of a free motion in 3 s, relative to their size.
        accuracy: greatest relative error of motions that are known in closed form.
        agreement: greatest distance (m) at any time between two flights that are the same motion described in two
            ways.
    """

    drift: ClassVar[float] = 1e-5
    accuracy: ClassVar[float] = 2e-3
    agreement: ClassVar[float] = 1e-3

    @pytest.mark.parametrize("what", NOT_FINITE)
    def test_an_impossible_agent_gives_a_failed_flight(self, what: str) -> None:
        """A flight whose added mass, centre of gravity, volume or damping is impossible has failed."""
        scenario = water_scenario(1.0, speed=1.0, pipe=(9.0, 1.0))
        assert self.plugin().simulate(NOT_FINITE[what](), scenario).end.failed

    def test_a_flight_starts_as_released(self) -> None:
        """The first sample has the attitude and the velocity of the release."""
        scenario = water_scenario(0.5, (0.4, 0.3, -0.2), speed=1.0, pitch_deg=30.0, position=(0.1, 0.2, 0.3))
        trajectory = self.fly(tumbling_agent(), scenario)
        half = math.radians(15)
        turned = trajectory.quaternion[0] * np.sign(trajectory.quaternion[0, 0])
        np.testing.assert_allclose(turned, (math.cos(half), 0, math.sin(half), 0), atol=1e-12)
        np.testing.assert_allclose(world_velocity(trajectory)[0], (0.4, 0.3, -0.2), atol=1e-12)
        np.testing.assert_allclose(trajectory.velocity[0, 3:], 0, atol=1e-12)

    def test_a_hundred_steps_equal_one_flight(self) -> None:
        """Without contact a body that tumbles in space is at the same place after them within 1e-6 m, in the same attitude."""
        agent, scenario = tumbling_agent(), water_scenario(1.0, (0.4, 0.3, -0.2), speed=0.5, pitch_deg=20.0)
        whole, flown = self.fly(agent, scenario), self.fly_in_steps(agent, scenario, 100)
        np.testing.assert_allclose(flown.position[-1], whole.position[-1], atol=1e-6)
        np.testing.assert_allclose(flown.velocity[-1], whole.velocity[-1], atol=1e-4)

    def test_a_release_has_roll_and_rates(self) -> None:
        """A neutral sphere that is released with a roll of 90 degrees and a yaw rate, about its z axis, turns about the world's -y."""
        scenario = water_scenario(0.5)
        release = scenario.release.model_copy(update={"roll_deg": 90.0, "rates": (0.0, 0.0, 0.8)})
        trajectory = self.fly(NEUTRAL, scenario.model_copy(update={"release": release}))
        np.testing.assert_allclose(trajectory.velocity[:, 3:], [[0.0, 0.0, 0.8]] * len(trajectory.t), atol=1e-6)
        nose = matrix_from_quaternion(trajectory.quaternion[-1])[:, 0]
        np.testing.assert_allclose(nose, (math.cos(0.4), 0.0, math.sin(0.4)), atol=1e-5)

    @pytest.mark.parametrize("what", MOTIONS)
    def test_a_motion_is_that_of_driftforms_own_integrator(self, what: str) -> None:
        """Position, attitude and first contact agree with those of the core, whose error is half a millionth of a millimetre."""
        agent, scenario = make_motion(what)
        trajectory = self.fly(agent, scenario)
        model = forces.flight_model(agent, scenario)
        start, horizon = forces.release_state(model, scenario), scenario.flight.horizon
        exact = solver.Accuracy(REFERENCE, tolerance=1e-10, max_step=0.01)
        flown = solver.integrate(model, start, horizon, exact)
        known = path.finish_trajectory(flown.samples, model, horizon, exact.step_limit, flown.error)
        times = np.linspace(0, horizon, 201)
        apart = largest_distance(*(interpolate_positions(flight, times) for flight in (trajectory, known)))
        assert apart < self.agreement
        assert trajectory.contact == pytest.approx(known.contact, abs=self.agreement)
        if what in ("libration", "tumbling with damping"):
            # The energy of the first is conserved.
            assert (trajectory.energy_drift is None) == (known.energy_drift is None)
            assert (trajectory.energy_drift or 0.0) <= self.drift
        assert trajectory.error is None or apart <= 3 * trajectory.error + 1e-6, "its estimated error is too small"
        R, Q = (matrix_from_quaternion(flight.quaternion[-1]) for flight in (trajectory, known))
        np.testing.assert_allclose(R, Q, atol=10 * self.agreement + 10 * self.accuracy)

    def test_the_seed_decides_the_gusts(self) -> None:
        """The same seed gives the same flight to the last bit, another seed another flight."""
        gusty = water_scenario(3.0, pipe=(9.0, 1.0), flow=TurbulentFlow(speed=1.0))
        first, again, other = (self.fly(SPHEROID.agent(), gusty.with_gusts(seed)) for seed in (1, 1, 2))
        assert same_content(first, again)
        assert largest_distance(first.position[-1:], other.position[-1:]) > 1e-3
        assert np.abs(first.position[-1, 1:]).max() > 1e-3

    def test_a_tumbling_flight_ends_exactly_at_the_outlet_too(self) -> None:
        """This holds also for a path that is not straight."""
        trajectory = self.fly(tumbling_agent(), water_scenario(20.0, speed=1.0, pipe=(2.0, 1.0)), End.OUTLET)
        assert trajectory.position[-1, 0] == pytest.approx(2.0, abs=1e-9)

    def test_a_flight_that_goes_back_through_the_inlet_ends_there(self) -> None:
        """An agent that leaves upstream ends its flight, which is not a failure."""
        trajectory = self.fly(NEUTRAL, water_scenario(20.0, (-1.0, 0.0, 0.0), pipe=(9.0, 0.5)), End.INLET)
        assert not trajectory.end.failed
        assert trajectory.position[-1, 0] < 0


def _parts_scenario(parts: list[dict[str, Any]], position: Vector = (0.1, 0.0, 0.0)) -> Scenario:
    """Return a scenario with a pipe of parts, 200 mm wide, and water of 0.5 m/s that carries the body along."""
    pipe = Pipe.model_validate({"segments": [], "radius": 0.1, "parts": parts})
    return water_scenario(30.0, speed=0.5, position=position).model_copy(update={"pipe": pipe})


def _narrow_scenario() -> Scenario:
    return water_scenario(1.5, (1.0, 0.2, 0.3), speed=1.0, pipe=(2.0, 0.3))


def _assert_finite(trajectory: Trajectory) -> None:
    for values in (trajectory.t, trajectory.position, trajectory.quaternion, trajectory.velocity):
        assert np.isfinite(values).all()


def largest_distance(a: FloatArray, b: FloatArray) -> float:
    """Return the largest distance (m) between corresponding points."""
    return float(np.linalg.norm(a - b, axis=1).max())
