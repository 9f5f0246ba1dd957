"""Motions with a known solution, and conservation laws: what driftform's simulators keep beside the contract of the seam.

Kirchhoff's equations for a spheroid that moves in a plane are those of a pendulum, whose solution are Jacobi's elliptic
functions (Lamb, Hydrodynamics, 6th ed., section 127).
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipj, ellipk
from textbook import distance_from_textbook, random_case

from driftform.motion.forces.inertia import added_mass_at, rigid_body_mass, shift_origin
from driftform.motion.path.curve import evaluate_path, world_velocity
from driftform.motion.path.interpolation import interpolate_positions
from driftform.testing import SimulatorContract
from driftform.testing.agents import DENSITY, GRAVITY, sphere_agent, tumbling_agent
from driftform.testing.simulator import NEUTRAL_MASS, RADIUS, SPHEROID, largest_distance, water_scenario
from driftform.types import Coefficients, Drag
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import Fluid


class Libration:
    """Planar motion of a spheroid in still water that starts with surge ``u`` and sway ``v`` (m/s) and no yaw rate.

    The impulse (M11 u, M22 v) = P (cos psi, sin psi) has constant length and direction in the world, so that
    psi' = -r. With chi = psi - pi/2 and sigma^2 = P^2 (M22 - M11) / (I M11 M22) the motion is the pendulum
    chi'^2 = sigma^2 (k^2 - sin^2 chi), k the sine of the amplitude, solved by sin chi = -k cd(sigma t | k^2).
    Its period is four quarter periods of the pendulum, s; its greatest yaw rate is sigma k, rad/s.
    """

    def __init__(self, spheroid, u, v):
        self._along, self._across, turning = total_of(spheroid)
        self._impulse = math.hypot(self._along * u, self._across * v)
        self._start = math.atan2(self._across * v, self._along * u)
        self._k, self._rest = math.cos(self._start), math.sin(self._start)
        inverse = (self._across - self._along) / (turning * self._along * self._across)
        self._sigma = self._impulse * math.sqrt(inverse)
        self.period = 4 * float(ellipk(self._k**2)) / self._sigma
        self.max_yaw_rate = self._sigma * self._k

    def motion_at(self, t):
        """Return surge, sway (m/s), yaw rate (rad/s) and heading (rad, 0 at the start) at the times (s, (n,)), (n, 4)."""
        sn, cn, dn, _ = ellipj(self._sigma * t, self._k**2)
        sine, cosine = -self._k * cn / dn, self._rest / dn
        surge, sway = -self._impulse * sine / self._along, self._impulse * cosine / self._across
        yaw_rate = -self._sigma * self._k * self._rest * sn / dn
        return np.column_stack([surge, sway, yaw_rate, self._start - (np.arctan2(sine, cosine) + math.pi / 2)])


def invariants(agent, scenario, trajectory):
    """Return energies and impulses along a flight in a uniform current, seen from the water.

    These are the kinetic energy of body and water, and the same plus the potential energy of weight and buoyancy, J,
    (k,); the impulse in the world frame, N s, and the angular impulse about a point that moves with the water, N m s,
    (k, 3).
    """
    matrix = rigid_body_mass(agent.mass) + added_mass_at(agent.coefficients, np.zeros(3))
    R = matrix_from_quaternion(trajectory.quaternion)
    current = scenario.current()
    nu = trajectory.velocity.copy()
    nu[:, :3] -= np.einsum("kji,j->ki", R, current)
    momentum = nu @ matrix
    place = trajectory.position - trajectory.t[:, None] * current
    impulse = np.einsum("kij,kj->ki", R, momentum[:, :3])
    turning = np.einsum("kij,kj->ki", R, momentum[:, 3:]) + np.cross(place, impulse)
    fluid, mass = scenario.fluid, agent.mass
    weight, buoyancy = mass.mass * fluid.gravity, fluid.density * mass.volume * fluid.gravity
    up = R[:, 2]
    potential = weight * (place[:, 2] + up @ mass.cog) - buoyancy * (place[:, 2] + up @ mass.cob)
    kinetic = 0.5 * (nu * momentum).sum(axis=1)
    return kinetic, kinetic + potential, impulse, turning


def total_of(spheroid):
    """Return mass with added mass along and across the axis (kg), and the same of the inertia (kg m2)."""
    k1, k2, turning = spheroid.factors
    return (1 + k1) * spheroid.mass, (1 + k2) * spheroid.mass, (1 + turning) * spheroid.inertia


def largest_drift(values):
    """Return the largest change of any component since the first sample."""
    return float(np.abs(values - values[0]).max())


def wall_depths(agent, trajectory, radius):
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


class ClosedForms(SimulatorContract):
    """The contract of simulators, and these motions; tolerances are those of the contract."""

    # Motions in a straight line.

    def test_the_core_alone_falls_with_its_added_mass(self):
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

    def test_drag_leads_to_the_terminal_velocity(self):
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

    def test_strips_across_the_axis_slow_a_body_that_falls_broadside(self):
        """A cylinder reaches the speed at which its drag, of strips and of creeping, equals its net weight."""
        length, diameter, mass = 0.3, 0.02, 1.2 * SPHEROID.mass
        strips = np.array([[x, diameter, length / 6, 1.0] for x in np.linspace(-0.125, 0.125, 6)])
        coefficients = SPHEROID.agent().coefficients
        drag = Drag(strips, creeping=(0.0, 40.0, 0.0, 0.0))
        agent = replace(agent_of(mass), coefficients=replace(coefficients, drag=drag))
        speed = -float(self.fly(agent, water_scenario(4.0)).velocity[-1, 2])
        Re = speed * diameter / 1.05e-6
        across = 0.5 * DENSITY * (1.18 + 1.96 / math.sqrt(Re)) * diameter * length * speed**2
        slowing = across + 40.0 * DENSITY * 1.05e-6 * speed
        assert slowing == pytest.approx((mass - SPHEROID.mass) * GRAVITY, rel=self.accuracy)

    # Kirchhoff's equations.

    def test_the_spheroid_librates_as_in_closed_form(self):
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
        np.testing.assert_allclose(trajectory.velocity[:, [0, 1, 5]] / size, expected[:, :3] / size, atol=self.accuracy)
        heading = np.unwrap(2 * np.arctan2(trajectory.quaternion[:, 3], trajectory.quaternion[:, 0]))
        np.testing.assert_allclose(heading, np.unwrap(expected[:, 3]), atol=self.accuracy * math.pi)
        assert np.abs(trajectory.velocity[:, [2, 3, 4]]).max() < 1e-6, "the motion has left its plane"

    @pytest.mark.parametrize("seed", range(10))
    def test_a_flight_agrees_with_fossens_equations(self, seed):
        """A body without symmetry, whose centres all lie elsewhere, flies as matrices and another integrator say."""
        agent, scenario = random_case(seed)
        trajectory = self.fly(agent, scenario)
        assert np.linalg.norm(np.diff(trajectory.position, axis=0), axis=1).sum() > 1.0, "it has to go somewhere"
        off = distance_from_textbook(trajectory, agent, scenario, scenario.flight.horizon)
        assert off < self.agreement
        assert trajectory.error is not None and off <= trajectory.error

    # Invariances.

    def test_a_current_is_a_change_of_frame(self):
        """Galilei: the motion in a uniform steady current U is that in still water with the velocity v - U, plus the drift U t."""
        agent = tumbling_agent(damped=True)
        there = self.fly(agent, water_scenario(2.0, (1.3, 0.2, -0.1), speed=1.0, pitch_deg=20.0))
        here = self.fly(agent, water_scenario(2.0, (0.3, 0.2, -0.1), speed=0.0, pitch_deg=20.0))
        times = np.linspace(0, 2.0, 201)
        carried = interpolate_positions(here, times) + np.outer(times, [1.0, 0.0, 0.0])
        assert largest_distance(interpolate_positions(there, times), carried) < self.agreement
        R, Q = (matrix_from_quaternion(trajectory.quaternion[-1]) for trajectory in (there, here))
        np.testing.assert_allclose(R, Q, atol=10 * self.agreement)

    def test_the_choice_of_origin_does_not_matter(self):
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

    def test_coefficients_may_refer_to_any_point(self):
        """``Coefficients.origin`` counts: the added mass may refer to another point."""
        agent = tumbling_agent()
        c, elsewhere = agent.coefficients, np.array([-0.03, 0.0, 0.02])
        matrix = shift_origin(c.added_mass, elsewhere - c.origin)
        H = np.eye(6)
        H[:3, 3:] = np.cross(np.eye(3), elsewhere - c.origin)
        np.testing.assert_allclose(matrix, H.T @ c.added_mass @ H, atol=1e-15)
        other = replace(agent, coefficients=Coefficients(matrix, origin=elsewhere))
        self._assert_flies_the_same(agent, other, np.zeros(3))

    def test_free_motion_conserves_energy_impulse_and_angular_impulse(self):
        """Without gravity a tumbling body exchanges them with the water, and the sums are constant."""
        agent = tumbling_agent()
        scenario = water_scenario(3.0, (1.0, 0.2, -0.1), pitch_deg=20.0, speed=0.5, gravity=0.0)
        trajectory = self.fly(agent, scenario)
        assert (np.abs(trajectory.velocity[:, 3:]).max(axis=0) > 1).all(), "the body must tumble about all three axes"
        _, energy, impulse, angular_impulse = invariants(agent, scenario, trajectory)
        assert largest_drift(energy) <= self.drift * energy[0]
        scale = float(np.linalg.norm(impulse[0]))
        assert largest_drift(impulse) <= self.drift * scale
        assert largest_drift(angular_impulse) <= self.drift * scale * agent.body.length

    def test_weight_and_buoyancy_do_the_work_of_their_heights(self):
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

    def test_a_floating_sphere_bobs_with_the_stiffness_of_its_waterline(self):
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

    def test_the_estimated_error_covers_the_true_error(self):
        """The estimate covers the error against the libration's closed form, and is at most 1 mm."""
        trajectory = self.fly(SPHEROID.agent(), water_scenario(1.0, (1.0, 0.01, 0.0)))
        assert trajectory.error is not None and 0 <= trajectory.error <= 1e-3
        surge, sway, _, heading = Libration(SPHEROID, 1.0, 0.01).motion_at(trajectory.t).T
        expected = (surge + 1j * sway) * np.exp(1j * heading)
        speed = world_velocity(trajectory)
        # The integral of the error of the velocity is the error of the position at the end.
        off = np.trapezoid(speed[:, 0] + 1j * speed[:, 1] - expected, trajectory.t)
        assert abs(off) <= 3 * trajectory.error + 1e-6

    def _assert_flies_the_same(self, agent, other, offset):
        """Assert that two descriptions of one agent, with origins ``offset`` (m) apart in its body axes, fly the same."""
        release = {"velocity": (0.3, 0.2, -0.1), "pitch_deg": 20.0}
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


def agent_of(mass):
    agent = SPHEROID.agent()
    return replace(agent, mass=replace(agent.mass, mass=mass))
