"""ExportJob -> the link that all formats write, about the centre of gravity and along the body's axes."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from driftform.interfaces import ExportJob
from driftform.motion import forces
from driftform.types import Body, FloatArray
from driftform.water import Scenario
from driftform_robotics.models.damping import linear_damping, quadratic_damping, reference_speed
from driftform_robotics.models.meshes import folds_back


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
        total = self.added_mass + np.diag([self.mass] * 3 + [0.0] * 3)
        along = total @ np.concatenate((self.rotation.T @ self.velocity, np.zeros(3)))
        return np.concatenate((self.rotation @ along[:3], self.rotation @ along[3:]))


def make_link(job: ExportJob, drag_speed: float | None = None) -> Link:
    """Return the link of a job, at its release."""
    from driftform.util import rotations

    agent, scenario = job.agent, job.scenario
    mass = agent.mass
    speed = drag_speed or reference_speed(agent, scenario.fluid)
    quaternion, velocity = scenario.release_quaternion(), scenario.release_velocity()
    return Link(
        mass=mass.mass,
        inertia=mass.inertia,
        volume=mass.volume,
        buoyancy=mass.cob - mass.cog,
        core=-mass.cog,
        added_mass=forces.added_mass_at(agent.coefficients, mass.cog),
        linear_damping=linear_damping(agent),
        quadratic_damping=quadratic_damping(agent, scenario.fluid, speed),
        added_mass_ratio=forces.largest_added_mass_ratio(mass, agent.coefficients),
        drag_speed=speed if agent.coefficients.drag is not None else 0.0,
        position=scenario.release_position() + rotations.matrix_from_quaternion(quaternion) @ mass.cog,
        quaternion=quaternion,
        velocity=scenario.current() if velocity is None else velocity,
    )


def warn_of_flow(scenario: Scenario) -> Iterator[str]:
    """Warn if a uniform, steady current cannot represent the scenario's flow."""
    flow = scenario.flow
    if not scenario.pipe.is_open and scenario.pipe.straight is None:
        yield (
            f"The current in this file is the mean at the inlet, {flow.speed:g} m/s in one direction everywhere: it does not "
            "turn with the pipe."
        )
    elif flow.kind != "uniform":
        yield (
            f"The flow '{flow.kind}' varies in space or time: the current in this file is its mean, "
            f"{flow.speed:g} m/s along the pipe."
        )
    elif flow.acceleration:
        yield f"The current's acceleration of {flow.acceleration:g} m/s2 is left out."


def warn_of_folding(body: Body) -> Iterator[str]:
    """Warn if the outline cannot be cut into convex pieces."""
    if folds_back(body.outer):
        yield (
            "The outline folds back along the axis: the hull collides as one piece, which most programs replace by its "
            "convex hull."
        )


def warn_of_damping(link: Link) -> Iterator[str]:
    """Warn if drag by strips was converted to quadratic damping."""
    if link.drag_speed:
        yield (
            "Quadratic damping replaces drag by strips: it is equal for motion along one axis at "
            f"{link.drag_speed:.3g} m/s, and smaller for motion along several axes at once."
        )


def describe_link(name: str, link: Link, axes: str = "y to port, z up") -> list[str]:
    """Describe the reference of a link's numbers, and whether lagging added mass diverges."""
    ratio = link.added_mass_ratio
    verdicts = [
        f"{'DIVERGES' if ratio >= find_limit(smoothing) else 'is stable'} in {program}"
        for program, smoothing in LAGS.items()
    ]
    return [
        f"The agent {name} of driftform in water: SI units, about its centre of gravity, with x forward along the axis, {axes}.",
        f"The added mass is at most {ratio:.3g} times the own mass. Solved together with the mass it is stable; multiplied by "
        f"the acceleration of the previous step it {', and '.join(verdicts)}.",
        *warn_of_damping(link),
    ]


LAGS = {"Gazebo Fortress": 1.0, "the UUV simulator": 0.3}
"""Programs that multiply added mass by an acceleration, and the weight of the previous step's in that."""


def find_limit(smoothing: float) -> float:
    """Return the ratio of added to own mass at which smoothed accelerations diverge.

    If accelerations are smoothed by a <- (1 - s) a + s da, with s = ``smoothing``, a mode whose ratio of added to own
    mass is lambda multiplies a by 1 - s - s lambda in every step: it diverges for lambda >= 2/s - 1.
    """
    return 2 / smoothing - 1


def warn_of_divergence(link: Link, smoothing: float) -> Iterator[str]:
    """Warn if added mass times the acceleration of the previous step diverges."""
    limit = find_limit(smoothing)
    if link.added_mass_ratio >= limit:
        yield (
            "UNSTABLE: this simulator multiplies the added mass by the acceleration of the previous step, which diverges "
            f"for any step if the added mass is {limit:.2f} times the agent's own mass or more; "
            f"here it is {link.added_mass_ratio:.2f} times."
        )
