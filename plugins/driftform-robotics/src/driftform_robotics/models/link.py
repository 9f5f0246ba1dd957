"""ExportJob -> the link that all formats write, about the centre of gravity and along the body's axes, with its damping."""

from dataclasses import dataclass, replace

import numpy as np

from driftform.interfaces import ExportJob
from driftform.motion import forces
from driftform.types import Agent, FloatArray
from driftform.water import Fluid
from driftform_robotics.models.text import list_lines

LAGS = {"Gazebo Fortress": 1.0, "the UUV simulator": 0.3}
"""Programs that multiply added mass by an acceleration, and the weight of the previous step's in that."""

MIN_SPEED = 0.05
"""Least speed, m/s, at which drag is converted: a neutral agent does not move through the water."""


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid body in water, about its centre of gravity.

    Attributes:
        mass, inertia: kg; kg m2, (3, 3).
        volume, buoyancy: displaced volume, m3; the centre of buoyancy, m, (3,).
        core: centre of the core, m, (3,).
        added_mass, linear_damping, quadratic_damping: (6, 6), positive if they resist motion, see
            :class:`driftform.types.Coefficients`.
        added_mass_ratio: largest eigenvalue of M_RB^-1 M_A.
        drag_speed: speed at which drag by strips was converted to quadratic damping, m/s; 0 without drag by strips.
        position, quaternion: position of the centre of gravity at the release, m, (3,); attitude, body to world,
            (4,).
        velocity: velocity at the release, world frame, m/s, (3,).
    """

    mass: float
    inertia: FloatArray
    volume: float
    buoyancy: FloatArray
    core: FloatArray
    added_mass: FloatArray
    linear_damping: FloatArray
    quadratic_damping: FloatArray
    added_mass_ratio: float
    drag_speed: float
    position: FloatArray
    quaternion: FloatArray
    velocity: FloatArray

    @property
    def rotation(self) -> FloatArray:
        """Attitude at the release, body to world, (3, 3)."""
        from driftform.util import rotations

        return rotations.matrix_from_quaternion(self.quaternion)

    @property
    def rigid_mass(self) -> FloatArray:
        """Mass matrix of the body without water, (6, 6)."""
        matrix = np.diag([self.mass] * 3 + [0.0] * 3)
        matrix[3:, 3:] = self.inertia
        return matrix

    @property
    def momentum(self) -> FloatArray:
        """Impulse that accelerates the body and its added mass from rest to the release velocity, world frame, (6,)."""
        along = (self.added_mass + self.rigid_mass) @ np.concatenate((self.rotation.T @ self.velocity, np.zeros(3)))
        return np.concatenate((self.rotation @ along[:3], self.rotation @ along[3:]))


def make_link(job: ExportJob, drag_speed: float | None = None) -> Link:
    """Return the link of a job, at its release."""
    from driftform.util import rotations

    agent, scenario = job.agent, job.scenario
    mass, coefficients = agent.mass, agent.coefficients
    speed = drag_speed or reference_speed(agent, scenario.fluid)
    quaternion, velocity = scenario.release_quaternion(), scenario.release_velocity()
    return Link(
        mass=mass.mass,
        inertia=mass.inertia,
        volume=mass.volume,
        buoyancy=mass.cob - mass.cog,
        core=-mass.cog,
        added_mass=forces.added_mass_at(coefficients, mass.cog),
        linear_damping=forces.shift_origin(coefficients.linear_damping, mass.cog - coefficients.origin),
        quadratic_damping=quadratic_damping(agent, scenario.fluid, speed),
        added_mass_ratio=forces.largest_added_mass_ratio(mass, coefficients),
        drag_speed=speed if coefficients.drag is not None else 0.0,
        position=scenario.release_position() + rotations.matrix_from_quaternion(quaternion) @ mass.cog,
        quaternion=quaternion,
        velocity=scenario.current() if velocity is None else velocity,
    )


def move_to_mass(link: Link, mass: float, inertia: float, density: float) -> Link:
    """Return a link whose own mass has a part of its added mass, which then needs no lag and no ellipsoid.

    The part is ``mass`` (kg) in all directions and ``inertia`` (kg m2) about both transverse axes. As much water (kg/m3)
    is displaced about the centre of gravity besides, so that weight and moment in water remain.
    """
    moved = np.diag([mass] * 3 + [0.0, inertia, inertia])
    volume, added = link.volume + mass / density, link.added_mass - moved
    return replace(
        link,
        mass=link.mass + mass,
        inertia=link.inertia + moved[3:, 3:],
        volume=volume,
        buoyancy=link.buoyancy * link.volume / volume,
        added_mass=added,
        added_mass_ratio=float(np.abs(np.linalg.eigvals(np.linalg.solve(link.rigid_mass + moved, added))).max()),
    )


def describe_link(name: str, link: Link, axes: str = "y to port, z up", is_fitted: bool = False) -> list[str]:
    """Describe the reference of a link's numbers, and whether lagging added mass diverges.

    ``is_fitted`` is whether the terms of a program were fitted to drag by strips.
    """
    limits = {program: find_limit(smoothing) for program, smoothing in LAGS.items()}
    return list_lines("link.txt", name=name, link=link, axes=axes, limits=limits, is_fitted=is_fitted)


def find_limit(smoothing: float) -> float:
    """Return the ratio of added to own mass at which smoothed accelerations diverge.

    If accelerations are smoothed by a <- (1 - s) a + s da, with s = ``smoothing``, a mode whose ratio of added to own
    mass is lambda multiplies a by 1 - s - s lambda in every step: it diverges for lambda >= 2/s - 1.
    """
    return 2 / smoothing - 1


def reference_speed(agent: Agent, fluid: Fluid) -> float:
    """Return the speed, m/s, at which an agent with drag by strips rises or sinks across its axis."""
    drag = agent.coefficients.drag
    if drag is None:
        return MIN_SPEED
    _, across = forces.terminal_speeds(drag, agent.mass.net_buoyancy(fluid), True, fluid.density, fluid.viscosity)
    return max(across, MIN_SPEED)


def quadratic_damping(agent: Agent, fluid: Fluid, speed: float) -> FloatArray:
    """Return D_2 about the centre of gravity, (6, 6): force and moment are -D_2 |nu| nu, component by component.

    Column j reproduces the force and moment of motion along axis j alone at ``speed`` (m/s), or of rotation about it
    at the rate at which the ends of the agent, half its length from the middle, move at that speed; both are means over
    the two directions. The effects of motion along several axes add up here. They do not with strips, whose drag
    depends on the total lateral speed. Quadratic damping about the centre of gravity is returned unchanged.
    """
    motions = list_single_motions(agent, speed)
    ahead, astern = np.split(np.array([quadratic_wrench(agent, fluid, nu) for nu in motions]), 2)
    damping: FloatArray = (astern - ahead).T / (2 * motions[:6].max(axis=1) ** 2)
    return damping


def list_single_motions(agent: Agent, speed: float) -> FloatArray:
    """Return motions along and about each axis alone, and then their opposites, (12, 6); see :func:`quadratic_damping`."""
    ahead = np.diag(np.repeat([speed, 2 * speed / agent.body.length], 3))
    return np.concatenate((ahead, -ahead))


def quadratic_wrench(agent: Agent, fluid: Fluid, nu: FloatArray) -> FloatArray:
    """Return the force and the moment about the centre of gravity of all but linear damping, N and N m, (6,).

    ``nu`` holds the velocity of the centre of gravity relative to the water, m/s, and the angular velocity, rad/s, both
    in body axes, (6,).
    """
    coefficients, cog = agent.coefficients, agent.mass.cog
    velocity, omega = nu[:3], nu[3:]
    wrench = np.zeros(6)

    def add(force: FloatArray, point: FloatArray) -> None:
        wrench[:3] += force
        wrench[3:] += np.cross(point - cog, force)

    there = np.concatenate((velocity + np.cross(omega, coefficients.origin - cog), omega))
    damping = -coefficients.quadratic_damping @ (np.abs(there) * there)
    wrench[3:] += damping[3:]
    add(damping[:3], coefficients.origin)
    drag = coefficients.drag
    if drag is not None:
        x, y, z = (velocity - np.cross(omega, cog)).tolist()
        p, q, r = omega.tolist()
        own = forces.still_water_wrench(drag, (x, y, z), (p, q, r), fluid.density, fluid.viscosity)
        wrench[3:] += own[3:]
        add(own[:3], np.zeros(3))
    return wrench
