"""How far an agent's path by the equations of the program that reads a file lies from its own path by driftform.

About the centre of gravity, in the frame of a uniform current, with (P, H) = M nu and nu = (v, w) in body axes (Fossen,
Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed., eq. 6.1 to 6.3)::

    (M_RB + M_A) nu' = (P x w, H x w + P x v) - D_1 nu - D_2 |nu| nu + weight and buoyancy

A program differs from it in the mass matrix, in M, in its damping, and by its steps.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from driftform.interfaces import ExportJob
from driftform.types import FloatArray
from driftform.water import Scenario
from driftform_robotics.models.link import Link

TIMES = (1.0, 3.0, 5.0)
"""Times after the release at which paths are compared, s."""

STEPS = (0.002, 0.001, 0.0005, 0.0002, 0.0001)
"""Steps of a simulation, s, of which the longest that is good enough is chosen."""

COMMON_STEP = 0.001
"""Default step of Gazebo, s."""

SHARE, NEGLIGIBLE = 0.1, 0.01
"""Largest error of a step at any of the times: relative to the gap, or m."""

POINTS = 500
"""Equal intervals of a path."""

_NONE = np.zeros((6, 6))


@dataclass(frozen=True, eq=False)
class Reader:
    """How a program moves a link.

    Attributes:
        name: of the program.
        added, momentum: added mass as a mass, and as a source of Coriolis forces, (6, 6).
        linear, quadratic: damping, (6, 6).
        smoothing: 0 if the program solves the added mass together with the mass. Otherwise it multiplies the added
            mass by the acceleration of the previous step, and this is the weight of the newest acceleration in that.
        density: of the water that lifts the link, kg/m3.
        turning: the current (m/s, world frame, (3,)) in which the program lacks -M_A (w x u) on a link that rotates
            at w.
    """

    name: str
    added: FloatArray
    momentum: FloatArray
    linear: FloatArray
    quadratic: FloatArray
    density: float
    smoothing: float = 0.0
    turning: FloatArray | Sequence[float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Gap:
    """How far two paths are apart, and the step of the one.

    Attributes:
        name: of the program.
        step: that was given or chosen, s.
        distances: at those of :data:`TIMES` to which driftform's flight lasts, m; not finite where the program's path
            diverges.
        is_coarse: whether none of :data:`STEPS` is short enough.
    """

    name: str
    step: float
    distances: dict[float, float]
    is_coarse: bool

    def describe(self) -> str:
        """Describe in a sentence how far the paths are apart."""
        near = [f"{d:.3g} m after {t:g} s" for t, d in self.distances.items() if np.isfinite(d)]
        if not near:
            return f"The path by {self.name} diverges, with steps of {self.step:g} s."
        end = ", and then diverges" if len(near) < len(self.distances) else ""
        return (
            f"The path by {self.name} is apart from driftform's in open water by {', '.join(near)}{end}, with steps of "
            f"{self.step:g} s." + (" A shorter step changes it further." if self.is_coarse else "")
        )


def read_link(name: str, link: Link, density: float) -> Reader:
    """Return a program that reads all of a link, in water of a density (kg/m3)."""
    return Reader(name, link.added_mass, link.added_mass, link.linear_damping, link.quadratic_damping, density)


def measure_gap(reader: Reader, job: ExportJob, link: Link, step: float | None = None) -> Gap:
    """Compare a program's path with the agent's own; without a ``step`` (s), choose it.

    The longest step is chosen whose error is small compared with the gap. If the path diverges at once with every step, because
    the added mass of the previous step does, the step is one of common use.
    """
    own = fly_own(job, link, TIMES[-1])
    index = np.round(np.array(TIMES) / TIMES[-1] * POINTS).astype(int)
    times = [t for t, i in zip(TIMES, index, strict=True) if np.isfinite(own[i]).all()]
    index = index[: len(times)]

    def fly(length: float) -> FloatArray:
        path: FloatArray = fly_reader(reader, job, link, TIMES[-1], length)[index]
        return path

    def make_gap(length: float, path: FloatArray, is_coarse: bool) -> Gap:
        apart = np.linalg.norm(path - own[index], axis=1).tolist()
        return Gap(reader.name, length, dict(zip(times, apart, strict=True)), is_coarse)

    if step is not None:
        return make_gap(step, fly(step), False)
    paths = {length: fly(length) for length in STEPS}
    limit = 2 * paths[STEPS[-1]] - paths[STEPS[-2]]
    if not np.isfinite(limit[:1]).all():
        return make_gap(COMMON_STEP, paths[COMMON_STEP], False)
    accepted = max(NEGLIGIBLE, SHARE * float(np.linalg.norm(limit - own[index], axis=1).max(initial=0.0)))
    for length, path in paths.items():
        if np.linalg.norm(path - limit, axis=1).max(initial=0.0) <= accepted:
            return make_gap(length, path, False)
    return make_gap(STEPS[-1], paths[STEPS[-1]], True)


def fly_own(job: ExportJob, link: Link, seconds: float) -> FloatArray:
    """Return the displacement of the centre of gravity relative to the water, m, (:data:`POINTS` + 1, 3).

    The flight is that of driftform in open water; it is not finite where that fails.
    """
    from driftform.motion import forces, path, solver
    from driftform.util import rotations

    fluid = job.scenario.fluid.model_copy(update={"water_level": None})
    calm = Scenario().flow.model_copy(update={"speed": 0.0})
    scenario = Scenario(fluid=fluid, flow=calm)
    model = forces.flight_model(job.agent, scenario)
    start = np.zeros(13)
    start[3:7] = link.quaternion
    start[7:10] = link.velocity - job.scenario.current()
    accuracy = solver.Accuracy(tolerance=1e-7)
    samples = solver.integrate_once(model, start, seconds, accuracy)
    flight = path.finish_trajectory(samples, model, seconds, accuracy.step_limit)
    times = np.linspace(0.0, seconds, POINTS + 1)
    found = np.full((len(times), 3), np.nan)
    flown = times <= flight.t[-1] + 1e-9
    turned = path.interpolate_attitudes(flight, times[flown])
    cog = job.agent.mass.cog
    offsets = np.array([rotations.matrix_from_quaternion(q) @ cog for q in turned]) - link.rotation @ cog
    found[flown] = path.interpolate_positions(flight, times[flown]) + offsets
    return found


def fly_reader(reader: Reader, job: ExportJob, link: Link, seconds: float, step: float) -> FloatArray:
    """Return a program's displacement relative to the water like :func:`fly_own`, with steps of ``step`` (s)."""
    from driftform_robotics.models.stepping import fill_path

    gravity, lift = job.scenario.fluid.gravity, reader.density * link.volume * job.scenario.fluid.gravity
    solved, lagged = (_NONE, reader.added) if reader.smoothing else (reader.added, _NONE)
    moving = link.rotation.T @ (link.velocity - job.scenario.current())
    lacking = reader.added if np.any(reader.turning) else _NONE
    # Steps longer than an interval are cut to it.
    every = max(1, round(seconds / POINTS / step))
    path = np.zeros((POINTS + 1, 3))
    fill_path(
        seconds / POINTS / every,
        every,
        link.rotation.copy(),
        np.concatenate((moving, np.zeros(3))),
        np.linalg.inv(link.rigid_mass + solved).astype(np.float64),
        link.rigid_mass + reader.momentum,
        np.array([reader.linear, reader.quadratic]),
        lagged.copy(),
        lacking.copy(),
        np.array([link.mass * gravity - lift, lift, *link.buoyancy, *reader.turning, reader.smoothing]),
        np.zeros((5, 6)),
        path[1:],
    )
    return path
