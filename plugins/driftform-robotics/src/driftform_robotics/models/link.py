"""ExportJob -> the one link that all formats write: everything about the centre of gravity, along the body's axes."""

from dataclasses import dataclass

import numpy as np

from driftform.dynamics.inertia import added_mass_at, largest_added_mass_ratio
from driftform.interfaces import ExportJob
from driftform.options import Table, option
from driftform.scenario import Scenario, UniformFlow
from driftform.types import Body, FloatArray
from driftform_robotics.models.damping import linear_damping, quadratic_damping, reference_speed
from driftform_robotics.models.meshes import folds_back


class ModelOptions(Table):
    """What every format offers that knows the water; its own options inherit from these."""

    drag_speed: float | None = option(
        None,
        "speed through the water at which drag by strips is turned into quadratic damping; "
        "without one that at which the agent rises or sinks",
        "m/s",
        gt=0,
        strict=True,
    )


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid body in water, about its centre of gravity.

    Attributes
    ----------
    mass, inertia
        kg; kg m2, (3, 3).
    volume, buoyancy
        displaced, m3; its centre, m, (3,).
    core
        the core's centre, m, (3,).
    added_mass, linear_damping, quadratic_damping
        (6, 6), all positive where they resist, see :class:`driftform.types.Coefficients`.
    added_mass_ratio
        largest eigenvalue of M_RB^-1 M_A.
    drag_speed
        at which drag by strips became quadratic damping, m/s; 0 where there is none.
    position, quaternion
        of the centre of gravity at the release, m, and body to world, (3,) and (4,).
    velocity
        of the release, world frame, m/s, (3,).
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
        from driftform.dynamics.rotations import matrix_from_quaternion

        return matrix_from_quaternion(self.quaternion)

    @property
    def momentum(self) -> FloatArray:
        """Impulse that brings body and water around it from rest to the release's velocity, world frame, (6,)."""
        total = self.added_mass + np.diag([self.mass] * 3 + [0.0] * 3)
        along = total @ np.concatenate((self.rotation.T @ self.velocity, np.zeros(3)))
        return np.concatenate((self.rotation @ along[:3], self.rotation @ along[3:]))


def make_link(job: ExportJob, drag_speed: float | None = None) -> Link:
    """Return the link of a job, at its release."""
    from driftform.dynamics.rotations import matrix_from_quaternion

    agent, scenario = job.agent, job.scenario
    mass = agent.mass
    speed = drag_speed or reference_speed(agent, scenario.fluid)
    quaternion = scenario.release_quaternion()
    return Link(
        mass=mass.mass,
        inertia=mass.inertia,
        volume=mass.volume,
        buoyancy=mass.cob - mass.cog,
        core=-mass.cog,
        added_mass=added_mass_at(agent.coefficients, mass.cog),
        linear_damping=linear_damping(agent),
        quadratic_damping=quadratic_damping(agent, scenario.fluid, speed),
        added_mass_ratio=largest_added_mass_ratio(mass, agent.coefficients),
        drag_speed=speed if agent.coefficients.drag is not None else 0.0,
        position=np.array(scenario.release.position) + matrix_from_quaternion(quaternion) @ mass.cog,
        quaternion=quaternion,
        velocity=_release_velocity(scenario),
    )


def _release_velocity(scenario: Scenario) -> FloatArray:
    velocity = scenario.release.velocity
    if velocity == "current":
        return scenario.current()
    return np.zeros(3) if velocity == "rest" else np.array(velocity, dtype=np.float64)


def warn_of_flow(scenario: Scenario) -> list[str]:
    """Tell what of a scenario's flow a current that is the same everywhere and always cannot hold."""
    flow = scenario.flow
    if not isinstance(flow, UniformFlow):
        return [
            f"The flow '{flow.kind}' is not the same everywhere: the current here is its mean, "
            f"{flow.speed:g} m/s along the pipe."
        ]
    if flow.acceleration:
        return [f"The current's acceleration of {flow.acceleration:g} m/s2 is left out."]
    return []


def warn_of_folding(body: Body) -> list[str]:
    """Tell of an outline that cannot be cut into convex pieces."""
    if not folds_back(body.outer):
        return []
    return [
        "The outline folds back along the axis: the hull collides in one piece, which most programs take for its "
        "convex hull."
    ]


def warn_of_damping(link: Link) -> list[str]:
    """Tell how drag by strips became quadratic damping."""
    if not link.drag_speed:
        return []
    return [
        f"Drag by strips is here quadratic damping: the same for motion along one axis at {link.drag_speed:.3g} m/s, "
        "less for motion along several at once."
    ]


def warn_of_divergence(link: Link, smoothing: float) -> list[str]:
    """Warn where added mass times the acceleration of the step before diverges.

    With accelerations smoothed by a <- (1 - s) a + s da, s being ``smoothing``, a mode of added over own mass
    lambda multiplies a by 1 - s - s lambda in every step: it diverges from lambda = 2/s - 1 on.
    """
    limit = 2 / smoothing - 1
    if link.added_mass_ratio < limit:
        return []
    return [
        f"UNSTABLE: this simulator takes the added mass times the acceleration of the step before, which diverges "
        f"from {limit:.2f} times the own mass on, whatever the step; this agent has {link.added_mass_ratio:.2f}."
    ]
