"""Contact of a body of revolution with the inside of a pipe: springs and dampers at its rims and domes, and friction."""

import math
from typing import TypeAlias

from driftform.motion.forces.bore import (
    AxisLine,
    axis_line,
    is_clear,
    lever_and_normal,
    smoothed_sine,
    surface_contact,
    transverse_parts,
)
from driftform.motion.forces.fitting_contact import line_in_straight, touch_fitting
from driftform.motion.forces.impact import common_mass, damper, spring
from driftform.motion.forces.model import FlightModel
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import (
    ZERO,
    Rotation,
    Vector,
    Wrench,
    add,
    add_wrenches,
    body_axis,
    cross,
    dot,
    force_wrench,
    multiply,
    scale,
    subtract,
    to_body,
    to_world,
)
from driftform.water.parts.walls import is_far_in_fittings

Touch: TypeAlias = tuple[float, Vector, Vector, float, float]
"""Depth in the wall (m, not positive if clear), lever from the body's origin (m) and the wall's normal in the world frame, and the
rim (x, r) that touches, m; of a dome, its centre."""


@compiled
def is_far_from_wall(position: Vector, reach: float, pipe: FloatArray, fittings: FloatArray | None = None) -> bool:
    """Return True if nothing within ``reach`` (m) of ``position`` can touch a wall; ``fittings`` replace ``pipe``."""
    if fittings is not None:
        return is_far_in_fittings(position, reach, fittings)
    if pipe.shape[0] == 0:
        return True
    off = subtract(position, (pipe[0, 0], pipe[0, 1], pipe[0, 2]))
    along, room = dot(off, (pipe[0, 3], pipe[0, 4], pipe[0, 5])), pipe[0, 7] - reach
    return bool(room > 0.0 and dot(off, off) - along * along < room * room)


@compiled
def is_near_wall(position: Vector, model: FlightModel, margin: float = 0.0) -> bool:
    """Return True if a surface of a body whose origin is at ``position`` may be within ``margin`` (m) of a wall."""
    return not is_far_from_wall(position, model.numbers[0].reach + margin, model.pipe, model.fittings)


@compiled
def signed_depth(
    position: Vector, axis: Vector, surface: int, model: FlightModel, fittings: FloatArray | None
) -> float:
    """Return the depth (m) of a surface in the wall, negative if it is clear: then at least as far as it is.

    ``position`` of the body's origin (m) and its ``axis`` are in the world frame; the pipe has a wall, and
    ``fittings`` are the model's.
    """
    # numba compiles no branch for an argument that is None.
    if fittings is not None:
        return touch_fitting(position, axis, model.surfaces, surface, fittings)[0]
    line = axis_line(transverse_parts(position, axis, model.pipe), model.pipe)
    return surface_contact(model.surfaces, surface, line)[2][0]


@compiled
def surface_depth(
    position: Vector,
    axis: Vector,
    line: AxisLine,
    parts: tuple[Vector, Vector],
    surface: int,
    model: FlightModel,
    fittings: FloatArray | None = None,
) -> Touch:
    """Return how a surface of the model touches the wall; ``line`` and ``parts`` are those of the body's axis in the bore.

    ``position`` of the body's origin (m) and its ``axis`` are in the world frame. A rim's farthest point defines the
    normal, and the normal defines the point; two rounds suffice in a wide bore.
    """
    surfaces = model.surfaces
    x, r = surfaces[surface, 0], surfaces[surface, 1]
    if is_clear(surfaces, surface, line):
        return 0.0, ZERO, ZERO, x, r
    if fittings is not None:
        return touch_fitting(position, axis, surfaces, surface, fittings)
    x, r, contact = surface_contact(surfaces, surface, line)
    lever, normal = lever_and_normal(axis, parts[0], parts[1], contact)
    return max(0.0, contact[0]), lever, normal, x, r


@compiled
def axis_in_bore(
    position: Vector, axis: Vector, reach: float, pipe: FloatArray, fittings: FloatArray | None
) -> tuple[AxisLine, tuple[Vector, Vector]]:
    """Return the position of the body's axis in a straight bore.

    In a pipe with parts it only shows which surfaces are clear, and is zero but where all within ``reach`` (m) is in one straight.
    """
    if fittings is not None:
        return line_in_straight(position, axis, reach, fittings), (ZERO, ZERO)
    parts = transverse_parts(position, axis, pipe)
    return axis_line(parts, pipe), parts


@compiled
def deepest_depth(position: Vector, R: Rotation, model: FlightModel) -> float:
    """Return the depth (m) of the deepest surface of the model in the wall, 0 if none touches."""
    deepest = 0.0
    if not is_far_from_wall(position, model.numbers[0].reach, model.pipe, model.fittings):
        axis = body_axis(R)
        line, parts = axis_in_bore(position, axis, model.numbers[0].reach, model.pipe, model.fittings)
        for k in range(model.surfaces.shape[0]):
            deepest = max(deepest, surface_depth(position, axis, line, parts, k, model, model.fittings)[0])
    return deepest


@compiled
def wall_wrench(position: Vector, R: Rotation, velocity: Vector, omega: Vector, model: FlightModel) -> Wrench:
    """Return force (N) and torque (N m) of the wall on the body, about the body's origin, in body axes.

    ``position`` (m) and ``velocity`` (m/s) of the body's origin are in the world frame, ``omega`` (rad/s) is in the
    body frame. The wall never pulls.

    Friction is that of a bristle at each surface: a spring k and a damper c in parallel, in series with a slider that slips
    where the force exceeds mu N (Coulomb). With the velocity v along the wall and the bristle's deflection z,::

        y = k z + c v        f = y min(1, mu N / |y|)        z' = (f - k z) / c

    and -f acts on the body: it sticks without creeping, and where it slides, f tends to mu N against the motion. With the
    mass m that a push along the wall moves, k = m omega^2 and c = m omega. ``model.bristles`` holds omega z of every surface;
    its second half is filled with the rates of these. Without friction it is empty.
    """
    n = model.numbers[0]
    law = n.law
    bristles, model.touches[0, 9] = model.bristles.shape[0] // 2, -1.0
    for k in range(bristles):
        for j in range(3):
            model.bristles[bristles + k, j] = -law.frequency * model.bristles[k, j]
    if is_far_from_wall(position, n.reach, model.pipe, model.fittings):
        return ZERO, ZERO
    axis, w = body_axis(R), to_world(R, omega)
    line, parts = axis_in_bore(position, axis, n.reach, model.pipe, model.fittings)
    springs, total, pressed, mass, count = (ZERO, ZERO), 0.0, 0.0, 0.0, 0
    for k in range(model.surfaces.shape[0]):
        depth, lever, normal, x, r = surface_depth(position, axis, line, parts, k, model, model.fittings)
        if depth > 0.0:
            mass, energy, force, turning = spring(dot(axis, normal), x, r, depth, law)
            total += energy * energy
            pressed += energy * force
            springs = add_wrenches(springs, force_wrench(lever, scale(-energy * force, normal)))
            _keep_touch(model.touches[count], k, lever, normal, energy, force, turning)
            count += 1
    model.touches[count, 9] = -1.0
    if not total > 0.0:
        return ZERO, ZERO
    root = math.sqrt(total)
    if count > 1:
        F, T = to_body(R, springs[0]), to_body(R, springs[1])
        a, alpha = multiply(n.inverse, F, T)
        mass = common_mass(pressed, dot(F, a) + dot(T, alpha), law)
    wrench = (ZERO, ZERO)
    for i in range(count):
        row = model.touches[i]
        lever, normal = (row[0], row[1], row[2]), (row[3], row[4], row[5])
        moving, share = add(velocity, cross(w, lever)), row[6] / root
        speed = dot(normal, moving)
        force = row[7] * share * damper(root / mass, speed, mass, law)
        push = scale(-force, normal)
        if bristles > 0:
            sliding = subtract(moving, scale(speed, normal))
            most = n.friction * force
            push = subtract(push, bristle_force(sliding, normal, most, int(row[9]), model))
        turn = scale(-row[8] * share / smoothed_sine(dot(axis, normal)), cross(axis, normal))
        wrench = add_wrenches(wrench, (push, add(cross(lever, push), turn)))
    return to_body(R, wrench[0]), to_body(R, wrench[1])


@compiled
def _keep_touch(
    row: FloatArray, k: int, lever: Vector, normal: Vector, energy: float, force: float, turning: float
) -> None:
    """Fill a row of :attr:`FlightModel.touches`."""
    for j in range(3):
        row[j], row[3 + j] = lever[j], normal[j]
    row[6], row[7], row[8], row[9] = energy, force, turning, k


@compiled
def bristle_force(sliding: Vector, normal: Vector, most: float, k: int, model: FlightModel) -> Vector:
    """Return the force (N) of surface ``k`` on the wall by friction, at most ``most``, and add it to the bristle's rate.

    ``sliding`` is the velocity along the wall, m/s; see :func:`wall_wrench`.
    """
    bent, mass = (model.bristles[k, 0], model.bristles[k, 1], model.bristles[k, 2]), model.surfaces[k, 6]
    trial = scale(mass * model.numbers[0].law.frequency, add(sliding, subtract(bent, scale(dot(normal, bent), normal))))
    size = math.sqrt(dot(trial, trial))
    force = trial if size <= most else scale(most / size, trial)
    for j in range(3):
        model.bristles[model.bristles.shape[0] // 2 + k, j] += force[j] / mass
    return force
