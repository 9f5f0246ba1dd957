"""Agents made from given values, whose motion is known in closed form or from conservation laws.

All values are in SI units, in water of 1024 kg/m3. Kirchhoff's equations for a spheroid that moves in a plane are
those of a pendulum, whose solution are Jacobi's elliptic functions (Lamb, Hydrodynamics, 6th ed., section 127).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from driftform.agent import mass_properties
from driftform.testing.bodies import hollow_body, spheroid_body
from driftform.types import Agent, Coefficients, End, MassProperties, Trajectory
from driftform.water import Pipe, Segment

DENSITY = 1024.0
"""Density of the water, kg/m3."""

GRAVITY = 9.81
"""Gravitational acceleration, m/s2."""


def straight_pipe(length: float, radius: float) -> Pipe:
    """Return a pipe along x from the origin, m."""
    return Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(length, 0.0, 0.0), radius=radius),))


def first_samples(trajectory: Trajectory, count: int = 1) -> Trajectory:
    """Return the flight that ended with its first samples, by default at its release."""
    t, n = trajectory, count
    return Trajectory(t.t[:n], t.position[:n], t.quaternion[:n], t.velocity[:n], End.INLET)


def hollow_agent() -> Agent:
    """Return a capped hollow tube, without a genome."""
    body = hollow_body()
    return Agent(body, mass_properties(body), Coefficients(0.01 * np.eye(6)))


def sphere_agent(radius: float, mass: float, added: float = 0.5, drag: float = 0.0) -> Agent:
    """Return a homogeneous sphere.

    Args:
        radius: of the sphere, m.
        mass: of the sphere, kg.
        added: added mass over displaced mass; 1/2 in potential flow.
        drag: drag coefficient on the frontal area, as quadratic damping of surge, sway and heave.
    """
    volume = 4 / 3 * math.pi * radius**3
    quadratic = 0.5 * DENSITY * drag * math.pi * radius**2
    return Agent(
        spheroid_body(radius, radius, edges=24),
        MassProperties(mass, np.zeros(3), 0.4 * mass * radius**2 * np.eye(3), volume, np.zeros(3)),
        Coefficients(
            np.diag([added * DENSITY * volume] * 3 + [0.0] * 3), quadratic_damping=np.diag([quadratic] * 3 + [0.0] * 3)
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
