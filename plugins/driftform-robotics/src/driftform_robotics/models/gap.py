"""How far an agent's path by the equations of the program that reads a file lies from its own path by driftform.

About the centre of gravity, in the frame of a uniform current, with (P, H) = M nu and nu = (v, w) in body axes (Fossen,
Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed., eq. 6.1 to 6.3)::

    (M_RB + M_A) nu' = (P x w, H x w + P x v) - D_1 nu - D_2 |nu| nu + weight and buoyancy

A program differs from it in the mass matrix, in M, in its damping, and by its steps.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from driftform.interfaces import ExportJob
from driftform.types import FloatArray, Trajectory
from driftform.water import Scenario
from driftform_robotics.models.link import Link
from driftform_robotics.models.text import list_lines

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
        added: added mass as a mass, (6, 6).
        linear: damping, (6, 6).
        products: forces of the water per product of the rates j and |k|, and of j and k, (2, 6, 6, 6).
        smoothing: 0 if the program solves the added mass together with the mass. Otherwise it multiplies the added
            mass by the acceleration of the previous step, and this is the weight of the newest acceleration in that.
        density: of the water that lifts the link, kg/m3.
        turning: the current (m/s, world frame, (3,)) in which the program lacks -M_A (w x u) on a link that rotates
            at w.
        ellipsoids: rows of :func:`driftform_robotics.models.ellipsoid.fit_ellipsoids`, for their drag and lift.
        is_checked: whether the program itself was found to fly so.
    """

    name: str
    added: FloatArray
    linear: FloatArray
    products: FloatArray
    density: float
    smoothing: float = 0.0
    turning: FloatArray | Sequence[float] = (0.0, 0.0, 0.0)
    ellipsoids: FloatArray = field(default_factory=lambda: np.zeros((0, 7)))
    is_checked: bool = False


@dataclass(frozen=True)
class Gap:
    """How far two paths are apart, and the step of the one.

    Attributes:
        reader: the program.
        step: that was given or chosen, s.
        distances: at those of :data:`TIMES` to which driftform's flight lasts, m; not finite where the program's path
            diverges.
    """

    reader: Reader
    step: float
    distances: dict[float, float]

    def describe(self) -> str:
        """Describe in a sentence how far the paths are apart."""
        near = {t: d for t, d in self.distances.items() if np.isfinite(d)}
        [sentence] = list_lines("gap.txt", gap=self, near=near)
        return sentence


def read_link(name: str, link: Link, density: float) -> Reader:
    """Return a program that reads all of a link, in water of a density (kg/m3)."""
    products = quadratic_products(link.quadratic_damping)
    products[1] += coriolis_products(link.added_mass)
    return Reader(name, link.added_mass, link.linear_damping, products, density)


def quadratic_products(damping: FloatArray) -> FloatArray:
    """Return the forces of quadratic damping per product of rates j and |k|, and of j and k, (2, 6, 6, 6)."""
    products = np.zeros((2, 6, 6, 6))
    products[0][:, range(6), range(6)] = -damping
    return products


def coriolis_products(matrix: FloatArray) -> FloatArray:
    """Return the forces (P x w, H x w + P x v) of a mass matrix, with (P, H) = M nu, per product of rates j <= k, (6, 6, 6)."""
    found = np.zeros((6, 6, 6))
    for j, k in product(range(6), range(6)):
        P, H = np.split(matrix[:, j], 2)
        v, w = np.split(np.eye(6)[k], 2)
        found[:, min(j, k), max(j, k)] += np.concatenate((np.cross(P, w), np.cross(H, w) + np.cross(P, v)))
    return found


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

    def make_gap(length: float, path: FloatArray) -> Gap:
        apart = np.linalg.norm(path - own[index], axis=1).tolist()
        return Gap(reader, length, dict(zip(times, apart, strict=True)))

    if step is not None:
        return make_gap(step, fly(step))
    paths = {length: fly(length) for length in STEPS}
    limit = 2 * paths[STEPS[-1]] - paths[STEPS[-2]]
    if not np.isfinite(limit[:1]).all():
        return make_gap(COMMON_STEP, paths[COMMON_STEP])
    accepted = max(NEGLIGIBLE, SHARE * float(np.linalg.norm(limit - own[index], axis=1).max(initial=0.0)))
    off = {length: np.linalg.norm(path - limit, axis=1).max(initial=0.0) for length, path in paths.items()}
    chosen = next((length for length in STEPS if off[length] <= accepted), STEPS[-1])
    return make_gap(chosen, paths[chosen])


def fly_calm(job: ExportJob, link: Link, seconds: float) -> Trajectory:
    """Return driftform's flight in open water at rest, with the link's attitude and velocity relative to the current."""
    from driftform.motion import forces, path, solver

    fluid = job.scenario.fluid.model_copy(update={"water_level": None})
    calm = Scenario().flow.model_copy(update={"speed": 0.0})
    model = forces.flight_model(job.agent, Scenario(fluid=fluid, flow=calm))
    start = np.zeros(13)
    start[3:7] = link.quaternion
    start[7:10] = link.velocity - job.scenario.current()
    accuracy = solver.Accuracy(tolerance=1e-7)
    samples = solver.integrate_once(model, start, seconds, accuracy)
    return path.finish_trajectory(samples, model, seconds, accuracy.step_limit)


def list_motions(job: ExportJob, link: Link) -> FloatArray:
    """Return velocities of the centre of gravity and angular velocities at even times of :func:`fly_calm`, (n, 6)."""
    flight = fly_calm(job, link, TIMES[-1])
    times = np.linspace(0.0, flight.t[-1], POINTS + 1)
    found = np.column_stack([np.interp(times, flight.t, rates) for rates in flight.velocity.T])
    found[:, :3] += np.cross(found[:, 3:], job.agent.mass.cog)
    return found


def fly_own(job: ExportJob, link: Link, seconds: float) -> FloatArray:
    """Return the displacement of the centre of gravity relative to the water, m, (:data:`POINTS` + 1, 3).

    The flight is :func:`fly_calm`; it is not finite where that fails.
    """
    from driftform.motion import path
    from driftform.util import rotations

    flight = fly_calm(job, link, seconds)
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
    from driftform.util import rotations
    from driftform_robotics.models.stepping import fill_path

    gravity, lift = job.scenario.fluid.gravity, reader.density * link.volume * job.scenario.fluid.gravity
    solved, lagged = (_NONE, reader.added) if reader.smoothing else (reader.added, _NONE)
    moving = link.rotation.T @ (link.velocity - job.scenario.current())
    lacking = reader.added if np.any(reader.turning) else _NONE
    products = reader.products.copy()
    products[1] += coriolis_products(link.rigid_mass)
    # Steps longer than an interval are cut to it.
    every = max(1, round(seconds / POINTS / step))
    path = np.zeros((POINTS + 1, 3))
    fill_path(
        seconds / POINTS / every,
        every,
        rotations.rotation_from_quaternion(*link.quaternion.tolist()),
        tuple(moving.tolist()),
        np.linalg.inv(link.rigid_mass + solved).astype(np.float64),
        reader.linear.copy(),
        products,
        reader.ellipsoids,
        lagged.copy(),
        lacking.copy(),
        (link.mass * gravity - lift, lift, reader.smoothing, reader.density),
        tuple(link.buoyancy.tolist()),
        tuple(np.array(reader.turning, dtype=float).tolist()),
        np.zeros(6),
        path[1:],
    )
    return path
