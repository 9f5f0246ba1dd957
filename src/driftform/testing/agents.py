"""Agents made from given values, whose motion is known in closed form or from conservation laws.

All values are in SI units, in water of 1024 kg/m3. Kirchhoff's equations for a spheroid that moves in a plane are
those of a pendulum, whose solution are Jacobi's elliptic functions (Lamb, Hydrodynamics, 6th ed., section 127).
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ellipj, ellipk

from driftform.motion.inertia import added_mass_at, rigid_body_mass
from driftform.testing.bodies import spheroid_body
from driftform.types import Agent, Coefficients, End, FloatArray, MassProperties, Trajectory
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import Pipe, Scenario, Segment

DENSITY = 1024.0
"""Density of the water, kg/m3."""

GRAVITY = 9.81
"""Gravitational acceleration, m/s2."""


def straight_pipe(length: float, radius: float) -> Pipe:
    """Return a pipe along x from the origin, m."""
    return Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(length, 0.0, 0.0), radius=radius),))


def first_sample(trajectory: Trajectory) -> Trajectory:
    """Return the flight that ended at its release."""
    t = trajectory
    return Trajectory(t.t[:1], t.position[:1], t.quaternion[:1], t.velocity[:1], End.INLET)


def sphere_agent(radius: float, mass: float, added: float = 0.5, drag: float = 0.0) -> Agent:
    """Return a homogeneous sphere.

    Args:
        radius, mass: of the sphere, m and kg.
        added: added mass over displaced mass; 1/2 in potential flow.
        drag: drag coefficient on the frontal area, as quadratic damping of surge, sway and heave.
    """
    volume = 4 / 3 * math.pi * radius**3
    quadratic = 0.5 * DENSITY * drag * math.pi * radius**2
    return Agent(
        spheroid_body(radius, radius, edges=24),
        MassProperties(mass, np.zeros(3), 0.4 * mass * radius**2 * np.eye(3), volume, np.zeros(3)),
        Coefficients(
            np.diag([added * DENSITY * volume] * 3 + [0.0] * 3),
            quadratic_damping=np.diag([quadratic] * 3 + [0.0] * 3),
        ),
    )


@dataclass(frozen=True)
class Spheroid:
    """A neutral, homogeneous prolate spheroid of half axis ``a`` and radius ``b``, m, in potential flow.

    Added mass after Lamb, sections 114 and 115: k1 along the axis and k2 across it, both of the displaced mass,
    and k' of the moment of inertia that the displaced water would have.

    Examples:
    >>> [round(k, 5) for k in Spheroid(0.06, 0.01).factors]
    [0.04518, 0.91712, 0.76231]
    """

    a: float
    b: float

    @property
    def volume(self) -> float:
        """Displaced volume, m3."""
        return 4 / 3 * math.pi * self.a * self.b**2

    @property
    def mass(self) -> float:
        """Mass, which is that of the displaced water, kg."""
        return DENSITY * self.volume

    @property
    def inertia(self) -> float:
        """Moment of inertia about a transverse axis, kg m2."""
        return self.mass * (self.a**2 + self.b**2) / 5

    @property
    def factors(self) -> tuple[float, float, float]:
        """The factors k1, k2 and k'."""
        e = math.sqrt(1 - (self.b / self.a) ** 2)
        alpha = 2 * (1 - e * e) / e**3 * (math.atanh(e) - e)
        beta = (2 - alpha) / 2
        d, s = self.a**2 - self.b**2, self.a**2 + self.b**2
        turning = d * d * (beta - alpha) / (s * (2 * d - s * (beta - alpha)))
        return alpha / (2 - alpha), beta / (2 - beta), turning

    @property
    def total(self) -> tuple[float, float, float]:
        """Mass with added mass along and across the axis (kg), and the same of the inertia (kg m2)."""
        k1, k2, turning = self.factors
        return (1 + k1) * self.mass, (1 + k2) * self.mass, (1 + turning) * self.inertia

    def agent(self) -> Agent:
        """Return the agent, with its origin at the centre."""
        k1, k2, turning = self.factors
        m, added = self.mass, turning * self.inertia
        inertia = np.diag([0.4 * m * self.b**2, self.inertia, self.inertia])
        return Agent(
            spheroid_body(self.a, self.b, edges=24),
            MassProperties(m, np.zeros(3), inertia, self.volume, np.zeros(3)),
            Coefficients(np.diag([k1 * m, k2 * m, k2 * m, 0.0, added, added])),
        )

    def munk_moment(self, speed: float, angle: float) -> float:
        """Return the destabilising moment (N m) of motion at ``speed`` (m/s) and ``angle`` (rad) to the axis."""
        k1, k2, _ = self.factors
        return 0.5 * (k2 - k1) * self.mass * speed**2 * math.sin(2 * angle)


class Libration:
    """Planar motion of a spheroid in still water that starts with surge ``u`` and sway ``v`` (m/s) and no yaw rate.

    The impulse (M11 u, M22 v) = P (cos psi, sin psi) has constant length and direction in the world, so that
    psi' = -r. With chi = psi - pi/2 and sigma^2 = P^2 (M22 - M11) / (I M11 M22) the motion is the pendulum
    chi'^2 = sigma^2 (k^2 - sin^2 chi), k the sine of the amplitude, solved by sin chi = -k cd(sigma t | k^2).
    Its period is four quarter periods of the pendulum, s; its greatest yaw rate is sigma k, rad/s.
    """

    def __init__(self, spheroid: Spheroid, u: float, v: float) -> None:
        self._along, self._across, turning = spheroid.total
        self._impulse = math.hypot(self._along * u, self._across * v)
        self._start = math.atan2(self._across * v, self._along * u)
        self._k, self._rest = math.cos(self._start), math.sin(self._start)
        inverse = (self._across - self._along) / (turning * self._along * self._across)
        self._sigma = self._impulse * math.sqrt(inverse)
        self.period = 4 * float(ellipk(self._k**2)) / self._sigma
        self.max_yaw_rate = self._sigma * self._k

    def motion_at(self, t: FloatArray) -> FloatArray:
        """Return surge, sway (m/s), yaw rate (rad/s) and heading (rad, 0 at the start) at the times (s, (n,)), (n, 4)."""
        sn, cn, dn, _ = ellipj(self._sigma * t, self._k**2)
        sine, cosine = -self._k * cn / dn, self._rest / dn
        surge, sway = -self._impulse * sine / self._along, self._impulse * cosine / self._across
        yaw_rate = -self._sigma * self._k * self._rest * sn / dn
        return np.column_stack(
            [surge, sway, yaw_rate, self._start - (np.arctan2(sine, cosine) + math.pi / 2)]
        )


def tumbling_agent(*, damped: bool = False) -> Agent:
    """Return a spheroid that is not neutral, with COG, COB and added mass at three different points off the axis.

    Its motion is not planar, and every entry of its 6x6 matrices about the origin matters.
    """
    agent = Spheroid(0.06, 0.02).agent()
    return replace(
        agent,
        mass=MassProperties(
            mass=0.9 * agent.mass.mass,
            cog=np.array([0.006, 0.003, -0.002]),
            inertia=1.1 * agent.mass.inertia + 1e-6 * np.array([[0, 1, 2], [1, 3, -1], [2, -1, 4]]),
            volume=agent.mass.volume,
            cob=np.array([-0.002, 0.001, 0.0]),
        ),
        coefficients=Coefficients(
            agent.coefficients.added_mass,
            origin=np.array([0.004, 0.0, 0.001]),
            linear_damping=damped * np.diag([0.02, 0.05, 0.05, 1e-6, 2e-5, 2e-5]),
            quadratic_damping=damped * np.diag([0.1, 0.5, 0.5, 0.0, 1e-5, 1e-5]),
        ),
    )


def invariants(
    agent: Agent, scenario: Scenario, trajectory: Trajectory
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
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
