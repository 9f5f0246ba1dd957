"""Contract of simulators: motions with a known solution, the ends of a flight, contact, and failures."""

import math
import pickle
from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar, Literal

import numpy as np
import pytest

from driftform.interfaces import Simulator
from driftform.motion.inertia import added_mass_at, shift_origin
from driftform.motion.interpolation import interpolate_positions
from driftform.motion.path import evaluate_path, world_velocity
from driftform.plugins.seams import require_flights
from driftform.testing.agents import (
    DENSITY,
    GRAVITY,
    Libration,
    Spheroid,
    invariants,
    sphere_agent,
    straight_pipe,
    tumbling_agent,
)
from driftform.testing.bodies import spheroid_body
from driftform.testing.contract import SeamContract
from driftform.types import Agent, Coefficients, Drag, End, FloatArray, Trajectory
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
        release=Release.model_validate(
            {"position": position, "pitch_deg": pitch_deg, "velocity": velocity},
        ),
        contact=Contact(restitution=restitution),
        flight=FlightLimits(horizon=horizon),
    ).model_copy(update=tables)


NOT_FINITE: dict[str, Callable[[], Agent]] = {
    "an added mass that is not a number": lambda: replace(
        HEAVY, coefficients=Coefficients(np.full((6, 6), np.nan))
    ),
    "a centre of gravity that is not a number": lambda: replace(
        HEAVY, mass=replace(HEAVY.mass, cog=np.full(3, np.nan))
    ),
    "an infinite volume": lambda: replace(HEAVY, mass=replace(HEAVY.mass, volume=math.inf)),
    "damping that feeds the motion": lambda: replace(
        HEAVY, coefficients=replace(HEAVY.coefficients, linear_damping=-1e3 * np.eye(6))
    ),
}


class PointSimulatorContract(SeamContract[Simulator[Any]]):
    """The contract of simulators of points, which know neither attitude nor inertia: neutral bodies drift with the water.

    Inherit this class as :class:`SimulatorContract`. It asks where a flight begins and ends, in straight pipes, bends and
    tees, that the water carries a neutral body, and that flights can be repeated.
    """

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
        """A neutral sphere on the axis ends in the plane of the outlet behind a bend of 90 degrees, and not beyond its wall."""
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

    def test_steps_carry_a_neutral_body_as_one_flight_does(self) -> None:
        """Ten steps of 50 ms in a cross current, with times since the release, end 0.5 m downstream of the release."""
        flow = UniformFlow(speed=1.0, added=(0.0, 0.2, -0.1))
        scenario, simulator = water_scenario(0.5, flow=flow), self.plugin()
        flown = [self.fly(NEUTRAL, water_scenario(0.05, flow=flow))]
        for _ in range(9):
            flown.append(simulator.step(NEUTRAL, scenario, flown[-1], 0.05))
            assert flown[-1].t[0] == flown[-2].t[-1]
        assert flown[-1].t[-1] == pytest.approx(0.5, rel=1e-9)
        np.testing.assert_allclose(flown[-1].position[-1], (0.5, 0.1, -0.05), atol=1e-6)

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
    def test_an_impossible_agent_gives_a_failed_flight_instead_of_an_exception(self, what: str) -> None:
        """The flight has failed, and its trajectory holds the finite samples: at least the release."""
        trajectory = self.plugin().simulate(
            NOT_FINITE[what](), water_scenario(1.0, speed=1.0, pipe=(9.0, 1.0))
        )
        assert trajectory.end.failed
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
            assert_identical(trajectory, simulator.simulate(agent, scenarios[0]))
            assert_identical(trajectory, reverse)
        assert simulator.simulate_batch([], []) == []

    def test_a_screened_flight_that_matters_is_the_simulated_one(self) -> None:
        """Flights that matter equal those of ``simulate`` to the last bit, with their estimated error."""
        agents, scenario = [tumbling_agent(), HEAVY, SPHEROID.agent()], _narrow_scenario()
        simulator = self.plugin()
        flights = simulator.screen_batch(agents, [scenario] * len(agents), lambda index, _: index != 1)
        for index in (0, 2):
            checked = simulator.simulate(agents[index], scenario)
            assert_identical(flights[index], checked)
            assert flights[index].error == checked.error

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
            assert_identical(flight, seen.get(index, checked))
            # The same flight, though nothing says how accurate it is.
            times = np.linspace(0.0, min(float(flight.t[-1]), float(checked.t[-1])), 101)
            paths = (interpolate_positions(flight, times), interpolate_positions(checked, times))
            assert largest_distance(*paths) < 0.05
        assert simulator.screen_batch([], [], matters) == []

    def test_the_same_flight_twice_is_the_same_to_the_last_bit(self) -> None:
        """Earlier flights have no effect, and a pickled copy in a worker process gives the same flight."""
        scenario = water_scenario(1.5, (1.0, 0.2, 0.3), speed=1.0, pitch_deg=10.0, pipe=(9.0, 0.3))
        simulator, agent = self.plugin(), tumbling_agent(damped=True)
        first = simulator.simulate(agent, scenario)
        simulator.simulate(HEAVY, water_scenario(0.5))
        assert_identical(first, simulator.simulate(agent, scenario))
        assert_identical(first, self.copy().simulate(*pickle.loads(pickle.dumps((agent, scenario)))))


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

    def test_a_flight_starts_as_released(self) -> None:
        """The first sample is the release: time 0, and its position, attitude and velocity."""
        scenario = water_scenario(0.5, (0.4, 0.3, -0.2), speed=1.0, pitch_deg=30.0, position=(0.1, 0.2, 0.3))
        trajectory = self.fly(tumbling_agent(), scenario)
        assert trajectory.t[0] == 0.0
        np.testing.assert_allclose(trajectory.position[0], (0.1, 0.2, 0.3), atol=1e-12)
        half = math.radians(15)
        turned = trajectory.quaternion[0] * np.sign(trajectory.quaternion[0, 0])
        np.testing.assert_allclose(turned, (math.cos(half), 0, math.sin(half), 0), atol=1e-12)
        np.testing.assert_allclose(world_velocity(trajectory)[0], (0.4, 0.3, -0.2), atol=1e-12)
        np.testing.assert_allclose(trajectory.velocity[0, 3:], 0, atol=1e-12)

    # Motions in a straight line.

    def test_the_core_alone_falls_with_its_added_mass(self) -> None:
        """a = (m - rho V) g / (m + m_A): a sphere of 0.05 kg falls with 8.59957 m/s2, without added mass with 8.96844 m/s2.

        A massless sphere rises with 2 g: coefficients of zero are valid, and so is a body without inertia.
        """
        for mass, added, known in ((0.05, 0.5, -8.59957), (0.05, 0.0, -8.96844), (0.0, 0.5, 2 * GRAVITY)):
            acceleration = (NEUTRAL_MASS - mass) * GRAVITY / (mass + added * NEUTRAL_MASS)
            assert acceleration == pytest.approx(known, abs=5e-6)
            trajectory = self.fly(sphere_agent(RADIUS, mass, added), water_scenario(0.5))
            fallen = 0.5 * acceleration * trajectory.t**2
            np.testing.assert_allclose(trajectory.position[:, 2], fallen, atol=1e-6)
            np.testing.assert_allclose(trajectory.velocity[:, 2], acceleration * trajectory.t, atol=2e-6)
            assert np.abs(trajectory.position[:, :2]).max() < 1e-9
            np.testing.assert_allclose(trajectory.velocity[:, 3:], 0, atol=1e-9)

    def test_drag_leads_to_the_terminal_velocity(self) -> None:
        """v = v_t tanh(t / tau) with quadratic damping: for Cd 0.47, 2.4355 m/s and 0.28321 s; 42.133 mm in 0.1 s."""
        drag = 0.5 * DENSITY * 0.47 * math.pi * RADIUS**2
        weight = (0.05 - NEUTRAL_MASS) * GRAVITY
        terminal = math.sqrt(weight / drag)
        tau = (0.05 + NEUTRAL_MASS / 2) * terminal / weight
        assert (terminal, tau) == pytest.approx((2.4355, 0.28321), abs=5e-5)
        assert terminal * tau * math.log(math.cosh(0.1 / tau)) == pytest.approx(0.042133, abs=5e-7)
        for horizon in (0.1, 1.0):
            trajectory = self.fly(sphere_agent(RADIUS, 0.05, drag=0.47), water_scenario(horizon))
            fallen = terminal * tau * np.log(np.cosh(trajectory.t / tau))
            np.testing.assert_allclose(-trajectory.position[:, 2], fallen, atol=self.accuracy * 1e-2)
            speed = terminal * np.tanh(trajectory.t / tau)
            np.testing.assert_allclose(-trajectory.velocity[:, 2], speed, atol=self.accuracy * 1e-1)

    def test_linear_damping_decays_exponentially(self) -> None:
        """m v' = -D v: with a rate of 2 1/s a neutral sphere stops after a path of v / 2, relative to the water."""
        damping = np.diag([2 * 1.5 * NEUTRAL_MASS] * 3 + [0.0] * 3)
        agent = replace(NEUTRAL, coefficients=replace(NEUTRAL.coefficients, linear_damping=damping))
        trajectory = self.fly(agent, water_scenario(2.0, "rest", speed=1.0))
        expected = trajectory.t - (1 - np.exp(-2 * trajectory.t)) / 2
        np.testing.assert_allclose(trajectory.position[:, 0], expected, atol=self.accuracy * 1e-2)

    def test_strips_across_the_axis_slow_a_body_that_falls_broadside(self) -> None:
        """A cylinder reaches the speed at which its drag, of strips and of creeping, equals its net weight."""
        length, diameter, mass = 0.3, 0.02, 1.2 * SPHEROID.mass
        strips = np.array([[x, diameter, length / 6, 1.0] for x in np.linspace(-0.125, 0.125, 6)])
        coefficients = SPHEROID.agent().coefficients
        drag = Drag(strips, creeping=(0.0, 40.0, 0.0, 0.0))
        agent = replace(_spheroid_of(mass), coefficients=replace(coefficients, drag=drag))
        speed = -float(self.fly(agent, water_scenario(4.0)).velocity[-1, 2])
        Re = speed * diameter / 1.05e-6
        across = 0.5 * DENSITY * (1.18 + 1.96 / math.sqrt(Re)) * diameter * length * speed**2
        slowing = across + 40.0 * DENSITY * 1.05e-6 * speed
        assert slowing == pytest.approx((mass - SPHEROID.mass) * GRAVITY, rel=self.accuracy)

    # Kirchhoff's equations.

    def test_the_spheroid_librates_as_in_closed_form(self) -> None:
        """From u = 1, v = 0.01, r = 0 surge, sway, yaw rate and heading follow Jacobi's elliptic functions for a period.

        The period is 1.128094 s, and the greatest yaw rate 19.09224 rad/s.
        """
        motion = Libration(SPHEROID, 1.0, 0.01)
        assert (motion.period, motion.max_yaw_rate) == pytest.approx((1.128094, 19.09224), abs=5e-6)
        [known] = motion.motion_at(np.array([1.0]))
        np.testing.assert_allclose(known[:3], (0.994499, 0.057973, 1.999774), atol=5e-7)
        trajectory = self.fly(SPHEROID.agent(), water_scenario(1.3, (1.0, 0.01, 0.0)))
        expected = motion.motion_at(trajectory.t)
        size = np.abs(expected[:, :3]).max(axis=0)
        np.testing.assert_allclose(
            trajectory.velocity[:, [0, 1, 5]] / size, expected[:, :3] / size, atol=self.accuracy
        )
        heading = np.unwrap(2 * np.arctan2(trajectory.quaternion[:, 3], trajectory.quaternion[:, 0]))
        np.testing.assert_allclose(heading, np.unwrap(expected[:, 3]), atol=self.accuracy * math.pi)
        assert np.abs(trajectory.velocity[:, [2, 3, 4]]).max() < 1e-6, "the motion has left its plane"

    def test_motion_at_an_angle_feels_munks_moment(self) -> None:
        """At 1 m/s and 10 degrees a moment of 0.0038375 N m turns the nose away: pitch acceleration = moment / (I + A55)."""
        moment = SPHEROID.munk_moment(1.0, math.radians(10))
        assert moment == pytest.approx(0.0038375, abs=5e-9)
        trajectory = self.fly(SPHEROID.agent(), water_scenario(1e-4, (1.0, 0.0, 0.0), pitch_deg=10.0))
        rate = trajectory.velocity[-1, 4] / trajectory.t[-1]
        assert rate == pytest.approx(moment / SPHEROID.total[2], rel=1e-4)

    def test_a_hundred_steps_equal_one_flight(self) -> None:
        """Without contact a body that tumbles in space is at the same place after them within 1e-6 m, in the same attitude."""
        agent, simulator = tumbling_agent(), self.plugin()
        scenario = water_scenario(1.0, (0.4, 0.3, -0.2), speed=0.5, pitch_deg=20.0)
        whole = self.fly(agent, scenario)
        flown = simulator.simulate(agent, water_scenario(0.01, (0.4, 0.3, -0.2), speed=0.5, pitch_deg=20.0))
        for _ in range(99):
            flown = simulator.step(agent, scenario, flown, 0.01)
        assert flown.t[-1] == pytest.approx(1.0, rel=1e-9) and flown.end is End.HORIZON
        np.testing.assert_allclose(flown.position[-1], whole.position[-1], atol=1e-6)
        np.testing.assert_allclose(flown.velocity[-1], whole.velocity[-1], atol=1e-4)

    def test_a_release_has_roll_and_rates(self) -> None:
        """A neutral sphere that is released with a roll of 90 degrees and a yaw rate, about its z axis, turns about the world's -y."""
        scenario = water_scenario(0.5)
        release = scenario.release.model_copy(update={"roll_deg": 90.0, "rates": (0.0, 0.0, 0.8)})
        trajectory = self.fly(NEUTRAL, scenario.model_copy(update={"release": release}))
        np.testing.assert_allclose(
            trajectory.velocity[:, 3:], [[0.0, 0.0, 0.8]] * len(trajectory.t), atol=1e-6
        )
        nose = matrix_from_quaternion(trajectory.quaternion[-1])[:, 0]
        np.testing.assert_allclose(nose, (math.cos(0.4), 0.0, math.sin(0.4)), atol=1e-5)

    # Invariances.

    def test_a_current_is_a_change_of_frame(self) -> None:
        """Galilei: the motion in a uniform steady current U is that in still water with the velocity v - U, plus the drift U t."""
        agent = tumbling_agent(damped=True)
        there = self.fly(agent, water_scenario(2.0, (1.3, 0.2, -0.1), speed=1.0, pitch_deg=20.0))
        here = self.fly(agent, water_scenario(2.0, (0.3, 0.2, -0.1), speed=0.0, pitch_deg=20.0))
        times = np.linspace(0, 2.0, 201)
        carried = interpolate_positions(here, times) + np.outer(times, [1.0, 0.0, 0.0])
        assert largest_distance(interpolate_positions(there, times), carried) < self.agreement
        R, Q = (matrix_from_quaternion(trajectory.quaternion[-1]) for trajectory in (there, here))
        np.testing.assert_allclose(R, Q, atol=10 * self.agreement)

    def test_the_choice_of_origin_does_not_matter(self) -> None:
        """The same agent with another origin of its body axes flies the same: A' = H^T A H for all its matrices."""
        agent, offset = tumbling_agent(damped=True), np.array([0.02, -0.01, 0.005])
        mass, coefficients = agent.mass, agent.coefficients
        # The contours are not moved, so that it may fly in open water only.
        moved = replace(
            agent,
            mass=replace(mass, cog=mass.cog - offset, cob=mass.cob - offset),
            coefficients=replace(coefficients, origin=coefficients.origin - offset),
        )
        for point in (np.zeros(3), np.array([0.1, 0.0, 0.05])):
            there = added_mass_at(moved.coefficients, point - offset)
            np.testing.assert_allclose(there, added_mass_at(coefficients, point), atol=1e-12)
        self._assert_flies_the_same(agent, moved, offset)

    def test_coefficients_may_refer_to_any_point(self) -> None:
        """``Coefficients.origin`` counts: the added mass may refer to another point."""
        agent = tumbling_agent()
        c, elsewhere = agent.coefficients, np.array([-0.03, 0.0, 0.02])
        matrix = shift_origin(c.added_mass, elsewhere - c.origin)
        H = np.eye(6)
        H[:3, 3:] = np.cross(np.eye(3), elsewhere - c.origin)
        np.testing.assert_allclose(matrix, H.T @ c.added_mass @ H, atol=1e-15)
        other = replace(agent, coefficients=Coefficients(matrix, origin=elsewhere))
        self._assert_flies_the_same(agent, other, np.zeros(3))

    def test_free_motion_conserves_energy_impulse_and_angular_impulse(self) -> None:
        """Without gravity a tumbling body exchanges them with the water, and the sums are constant."""
        agent = tumbling_agent()
        scenario = water_scenario(3.0, (1.0, 0.2, -0.1), pitch_deg=20.0, speed=0.5, gravity=0.0)
        trajectory = self.fly(agent, scenario)
        assert (np.abs(trajectory.velocity[:, 3:]).max(axis=0) > 1).all(), (
            "the body must tumble about all three axes"
        )
        _, energy, impulse, angular_impulse = invariants(agent, scenario, trajectory)
        assert largest_drift(energy) <= self.drift * energy[0]
        scale = float(np.linalg.norm(impulse[0]))
        assert largest_drift(impulse) <= self.drift * scale
        assert largest_drift(angular_impulse) <= self.drift * scale * agent.body.length

    def test_weight_and_buoyancy_do_the_work_of_their_heights(self) -> None:
        """With gravity the energy is conserved too, and so are the impulses that a vertical force cannot change."""
        agent = tumbling_agent()
        scenario = water_scenario(3.0, (0.5, 0.1, 0.0), pitch_deg=20.0)
        kinetic, energy, impulse, angular_impulse = invariants(agent, scenario, self.fly(agent, scenario))
        assert largest_drift(energy) <= self.drift * kinetic.max()
        scale = float(np.linalg.norm(impulse, axis=1).max())
        assert largest_drift(impulse[:, :2]) <= self.drift * scale
        assert largest_drift(angular_impulse[:, 2]) <= self.drift * scale * agent.body.length
        net = (DENSITY * agent.mass.volume - agent.mass.mass) * GRAVITY
        assert impulse[-1, 2] - impulse[0, 2] == pytest.approx(3.0 * net, rel=1e-4)

    # Water that is not uniform and steady.

    @pytest.mark.parametrize(
        ("shape", "force", "share"),
        [("sphere", "full", 1.0), ("spheroid", "full", 1.0), ("sphere", "paper", 1 / 3)],
    )
    def test_a_neutral_body_moves_with_accelerating_water(
        self, shape: str, force: Literal["full", "paper"], share: float
    ) -> None:
        """This holds at any attitude; without the pressure gradient, as in the paper, m_A / (m + m_A) of it is left."""
        agent = NEUTRAL if shape == "sphere" else SPHEROID.agent()
        fluid = Fluid(density=DENSITY, gravity=GRAVITY, flow_force=force)
        flow = UniformFlow(speed=0.0, acceleration=1.0)
        trajectory = self.fly(agent, water_scenario(2.0, pitch_deg=35.0, flow=flow, fluid=fluid))
        expected = np.outer(0.5 * share * trajectory.t**2, [1.0, 0.0, 0.0])
        np.testing.assert_allclose(trajectory.position, expected, atol=1e-6)
        np.testing.assert_allclose(trajectory.velocity[:, 3:], 0, atol=1e-6)

    def test_the_seed_decides_the_gusts(self) -> None:
        """The same seed gives the same flight to the last bit, another seed another flight."""
        gusty = water_scenario(3.0, pipe=(9.0, 1.0), flow=TurbulentFlow(speed=1.0))
        first, again, other = (self.fly(SPHEROID.agent(), gusty.with_gusts(seed)) for seed in (1, 1, 2))
        assert_identical(first, again)
        assert largest_distance(first.position[-1:], other.position[-1:]) > 1e-3
        assert np.abs(first.position[-1, 1:]).max() > 1e-3

    def test_a_floating_sphere_bobs_with_the_stiffness_of_its_waterline(self) -> None:
        """A sphere of half the density of water floats half under; the square of its frequency is pi r^2 rho g over its mass."""
        agent = sphere_agent(0.05, 0.5 * DENSITY * 4 / 3 * math.pi * 0.05**3)
        fluid = Fluid(density=DENSITY, gravity=GRAVITY, water_level=0.0)
        trajectory = self.fly(agent, water_scenario(2.0, position=(0.0, 0.0, 0.003), fluid=fluid))
        stiffness = math.pi * 0.05**2 * DENSITY * GRAVITY
        swinging = agent.mass.mass + agent.coefficients.added_mass[2, 2]
        t, height = trajectory.t, trajectory.position[:, 2]
        np.testing.assert_allclose(height.max(), 0.003, rtol=self.accuracy)
        k = np.flatnonzero(np.sign(height[1:]) != np.sign(height[:-1]))
        crossings = t[k] - height[k] * (t[k + 1] - t[k]) / (height[k + 1] - height[k])
        # The waterline narrows away from the middle, and the body is divided into slices: an error of one percent each.
        half_period = math.pi * math.sqrt(swinging / stiffness)
        assert float(np.diff(crossings).mean()) == pytest.approx(half_period, rel=0.02)

    def test_a_body_far_below_the_surface_moves_as_in_a_full_pipe(self) -> None:
        """A surface far above the body does not change its motion."""
        times, paths = np.linspace(0, 1.5, 151), []
        for level in (None, 50.0):
            fluid = Fluid(density=DENSITY, gravity=GRAVITY, water_level=level)
            scenario = water_scenario(1.5, (0.5, 0.1, 0.0), pitch_deg=20.0, fluid=fluid)
            paths.append(interpolate_positions(self.fly(SPHEROID.agent(), scenario), times))
        assert largest_distance(*paths) < self.agreement

    # Ends of a flight.

    def test_a_tumbling_flight_ends_exactly_at_the_outlet_too(self) -> None:
        """This holds also for a path that is not straight."""
        trajectory = self.fly(tumbling_agent(), water_scenario(20.0, speed=1.0, pipe=(2.0, 1.0)), End.OUTLET)
        assert trajectory.position[-1, 0] == pytest.approx(2.0, abs=1e-9)

    def test_a_flight_that_goes_back_through_the_inlet_ends_there(self) -> None:
        """An agent that leaves upstream ends its flight, which is not a failure."""
        trajectory = self.fly(NEUTRAL, water_scenario(20.0, (-1.0, 0.0, 0.0), pipe=(9.0, 0.5)), End.INLET)
        assert not trajectory.end.failed
        assert trajectory.position[-1, 0] < 0

    # Contact with the wall.

    @pytest.mark.parametrize("restitution", [0.2, 0.7, 0.95])
    def test_a_sphere_that_hits_the_wall_returns_with_the_restitution(self, restitution: float) -> None:
        """It enters by less than a millimetre, slides on, and keeps the share e exp(-35 / St) of its speed, within .05."""
        hit, pipe = 0.5, (9.0, 0.2)
        scenario = water_scenario(0.8, (1.0, 0.0, hit), speed=1.0, pipe=pipe, restitution=restitution)
        trajectory = self.fly(NEUTRAL, scenario)
        depth = wall_depths(NEUTRAL, trajectory, 0.2)
        assert depth.max() > 0, "the sphere must reach the wall"
        assert depth.max() < 1e-3
        speed = world_velocity(trajectory)[-1]
        assert speed[0] == pytest.approx(1.0, abs=1e-6), "the wall is frictionless"
        viscosity = scenario.fluid.viscosity * scenario.fluid.density
        stokes = 1.5 * NEUTRAL_MASS * hit / (6 * math.pi * viscosity * RADIUS**2)
        assert -speed[2] / hit == pytest.approx(restitution * math.exp(-35 / stokes), abs=0.05)

    def test_a_long_body_that_hits_the_wall_obliquely_stays_inside_and_loses_energy(self) -> None:
        """No rim enters by more than a millimetre, and the wall never returns more energy than it takes."""
        agent = SPHEROID.agent()
        scenario = water_scenario(2.0, (1.0, 0.0, 0.4), speed=1.0, pitch_deg=-20.0, pipe=(9.0, 0.2))
        trajectory = self.fly(agent, scenario)
        _, energy, _, _ = invariants(agent, scenario, trajectory)
        assert 0 < wall_depths(agent, trajectory, 0.2).max() < 1e-3
        assert energy[-1] < 0.9 * energy[0]
        assert energy.max() <= energy[0] * 1.002

    def test_a_light_body_comes_to_rest_against_the_wall(self) -> None:
        """It rests at a depth below 0.1 mm, where the springs balance the net buoyancy, and drifts with the water."""
        # So few edges that only the widest rim touches.
        agent = replace(
            _spheroid_of(0.5 * SPHEROID.mass), body=spheroid_body(SPHEROID.a, SPHEROID.b, edges=4)
        )
        scenario = water_scenario(3.0, speed=1.0, pipe=(9.0, 0.1), restitution=0.5)
        trajectory = self.fly(agent, scenario)
        acceleration = 0.5 * GRAVITY / (0.5 + SPHEROID.factors[1])
        static = acceleration / scenario.contact.frequency**2
        assert trajectory.position[-1, 2] - (0.1 - SPHEROID.b) == pytest.approx(static, rel=0.05)
        assert static < 1e-4
        np.testing.assert_allclose(world_velocity(trajectory)[-1], [1.0, 0.0, 0.0], atol=1e-3)

    def test_friction_brings_a_body_on_the_wall_to_rest(self) -> None:
        """A body that slides in still water slows down to rest."""
        release: dict[str, Any] = {"position": (1.0, 0.0, -0.089), "pipe": (9.0, 0.1)}
        scenario = water_scenario(4.0, (0.5, 0.0, 0.0), **release, contact=Contact(friction=0.4))
        trajectory = self.fly(_spheroid_of(1.5 * SPHEROID.mass), scenario)
        assert abs(world_velocity(trajectory)[-1, 0]) < 1e-3
        # By sliding only, with mu times a third of its weight, it would move this far; rocking shortens the path.
        slowing = 0.4 * (0.5 / 1.5) * GRAVITY / (1 + SPHEROID.factors[0] / 1.5)
        assert 0 < trajectory.position[-1, 0] - 1.0 < 1.5 * 0.5**2 / (2 * slowing)

    # Diagnostics of a flight.

    def test_the_first_contact_with_the_wall_is_recorded(self) -> None:
        """A sphere that falls freely through half a metre touches after sqrt(2 s / a); in open water ``contact`` is ``None``."""
        acceleration = (0.05 - NEUTRAL_MASS) * GRAVITY / (0.05 + NEUTRAL_MASS / 2)
        trajectory = self.fly(HEAVY, water_scenario(0.6, speed=1.0, pipe=(9.0, 0.5)))
        # The polyline of the body is known to be a sphere.
        fallen = math.sqrt(2 * (0.5 - RADIUS) / acceleration)
        assert trajectory.contact == pytest.approx(fallen, rel=self.accuracy)
        assert self.fly(HEAVY, water_scenario(0.5)).contact is None

    def test_the_estimated_error_covers_the_true_error(self) -> None:
        """The estimate covers the error against the libration's closed form, and is at most 1 mm."""
        trajectory = self.fly(SPHEROID.agent(), water_scenario(1.0, (1.0, 0.01, 0.0)))
        assert trajectory.error is not None and 0 <= trajectory.error <= 1e-3
        surge, sway, _, heading = Libration(SPHEROID, 1.0, 0.01).motion_at(trajectory.t).T
        expected = (surge + 1j * sway) * np.exp(1j * heading)
        speed = world_velocity(trajectory)
        # The integral of the error of the velocity is the error of the position at the end.
        off = np.trapezoid(speed[:, 0] + 1j * speed[:, 1] - expected, trajectory.t)
        assert abs(off) <= 3 * trajectory.error + 1e-6

    def test_the_energy_drift_is_recorded_if_energy_is_conserved(self) -> None:
        """Free motion conserves the energy; for damped motion ``energy_drift`` is ``None``."""
        trajectory = self.fly(SPHEROID.agent(), water_scenario(1.2, (1.0, 0.01, 0.0)))
        assert trajectory.energy_drift is not None and trajectory.energy_drift <= self.drift
        assert self.fly(tumbling_agent(damped=True), water_scenario(0.5)).energy_drift is None

    def _assert_flies_the_same(self, agent: Agent, other: Agent, offset: FloatArray) -> None:
        """Assert that two descriptions of one agent, with origins ``offset`` (m) apart in its body axes, fly the same."""
        release: dict[str, Any] = {"velocity": (0.3, 0.2, -0.1), "pitch_deg": 20.0}
        scenario = water_scenario(2.0, **release)
        start = matrix_from_quaternion(scenario.release_quaternion()) @ offset
        elsewhere = water_scenario(2.0, **release, position=tuple(start.tolist()))
        trajectory, again = self.fly(agent, scenario), self.fly(other, elsewhere)
        R = matrix_from_quaternion(again.quaternion)
        turned = np.einsum("kij,j->ki", R, offset)
        velocity = world_velocity(again) - np.einsum("kij,kj->ki", R, np.cross(again.velocity[:, 3:], offset))
        times = np.linspace(0, 2.0, 201)
        back = evaluate_path(again.t, again.position - turned, velocity, times)
        assert largest_distance(interpolate_positions(trajectory, times), back) < self.agreement


def _parts_scenario(parts: list[dict[str, Any]], position: Vector = (0.1, 0.0, 0.0)) -> Scenario:
    """Return a scenario with a pipe of parts, 200 mm wide, and water of 0.5 m/s that carries the body along."""
    pipe = Pipe.model_validate({"segments": [], "radius": 0.1, "parts": parts})
    return water_scenario(30.0, speed=0.5, position=position).model_copy(update={"pipe": pipe})


def _narrow_scenario() -> Scenario:
    return water_scenario(1.5, (1.0, 0.2, 0.3), speed=1.0, pipe=(2.0, 0.3))


def _spheroid_of(mass: float) -> Agent:
    agent = SPHEROID.agent()
    return replace(agent, mass=replace(agent.mass, mass=mass))


def _assert_finite(trajectory: Trajectory) -> None:
    for values in (trajectory.t, trajectory.position, trajectory.quaternion, trajectory.velocity):
        assert np.isfinite(values).all()


def largest_drift(values: FloatArray) -> float:
    """Return the largest change of any component since the first sample."""
    return float(np.abs(values - values[0]).max())


def largest_distance(a: FloatArray, b: FloatArray) -> float:
    """Return the largest distance (m) between corresponding points."""
    return float(np.linalg.norm(a - b, axis=1).max())


def wall_depths(agent: Agent, trajectory: Trajectory, radius: float) -> FloatArray:
    """Return how far (m) the agent extends beyond the wall of a pipe along x, at each sample, (k,).

    ``radius`` (m) is the pipe's. Every rim of the body is sampled in steps of 5 degrees.
    """
    R = matrix_from_quaternion(trajectory.quaternion)
    angles = np.deg2rad(np.arange(0, 360, 5))
    x, r = agent.body.outer.T
    around = [np.outer(r, np.cos(angles)).ravel(), np.outer(r, np.sin(angles)).ravel()]
    ring = np.stack([np.repeat(x, len(angles)), *around])
    across = trajectory.position[:, 1:, None] + R[:, 1:] @ ring
    return np.asarray(np.linalg.norm(across, axis=1).max(axis=1) - radius, dtype=np.float64)


def assert_identical(a: Trajectory, b: Trajectory) -> None:
    """Assert that two trajectories are equal to the last bit."""
    assert a.end == b.end
    for name in ("t", "position", "quaternion", "velocity"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
