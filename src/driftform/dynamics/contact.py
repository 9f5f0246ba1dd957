"""Contact of a body of revolution with the inside of a pipe: springs and dampers at its rims and domes, and friction."""

import math
from typing import TypeAlias

import numpy as np

from driftform.dynamics.bore import (
    ANGLE_TOLERANCE,
    AxisLine,
    axis_line,
    end_of_dome,
    is_clear,
    lever_and_normal,
    smoothed_sine,
    surface_contact,
    transverse_parts,
)
from driftform.dynamics.impact import FREQUENCY, common_mass, damper, spring
from driftform.dynamics.model import FRICTION, INVERSE, LINEAR, REACH, FlightModel
from driftform.dynamics.vectors import (
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
from driftform.types import FloatArray
from driftform.util.compiled import compiled

Touch: TypeAlias = tuple[float, Vector, Vector, float, float]
"""Depth in the wall (m, 0 if clear), lever from the body's origin (m) and the wall's normal in the world frame, and the
rim (x, r) that touches, m; of a dome, its centre."""


@compiled
def wall_gap(point: Vector, pipe: FloatArray) -> tuple[float, Vector]:
    """Return the distance from ``point`` to the wall (m, negative outside the pipe), and the unit vector to the wall.

    The pipe (see :class:`driftform.dynamics.model.FlightModel`) is the union of its segments' bores; the first and
    the last continue beyond their outer ends. If the point lies on an axis, the vector is zero.
    """
    best, normal = -np.inf, ZERO
    last = pipe.shape[0] - 1
    for s in range(pipe.shape[0]):
        axis = (pipe[s, 3], pipe[s, 4], pipe[s, 5])
        off = subtract(point, (pipe[s, 0], pipe[s, 1], pipe[s, 2]))
        along = dot(axis, off)
        if s > 0:
            along = max(along, 0.0)
        if s < last:
            along = min(along, pipe[s, 6])
        off = subtract(off, scale(along, axis))
        distance = math.sqrt(dot(off, off))
        if pipe[s, 7] - distance > best:
            best = pipe[s, 7] - distance
            normal = scale(1.0 / distance, off) if distance > 0.0 else ZERO
    return best, normal


@compiled
def is_far_from_wall(position: Vector, reach: float, pipe: FloatArray) -> bool:
    """Return True if nothing within ``reach`` (m) of ``position`` can touch a wall."""
    if pipe.shape[0] != 1:
        return pipe.shape[0] == 0 or wall_gap(position, pipe)[0] > reach
    off = subtract(position, (pipe[0, 0], pipe[0, 1], pipe[0, 2]))
    along, room = dot(off, (pipe[0, 3], pipe[0, 4], pipe[0, 5])), pipe[0, 7] - reach
    return bool(room > 0.0 and dot(off, off) - along * along < room * room)


@compiled
def farthest_rim_point(centre: Vector, axis: Vector, r: float, normal: Vector) -> Vector:
    """Return the point of a rim of radius ``r`` (m) that lies farthest along ``normal``, world frame, m."""
    s = dot(axis, normal)
    return add(centre, scale(r / smoothed_sine(s), subtract(normal, scale(s, axis))))


@compiled
def surface_depth(
    position: Vector,
    axis: Vector,
    line: AxisLine,
    parts: tuple[Vector, Vector],
    surface: int,
    model: FlightModel,
) -> Touch:
    """Return how a surface of the model touches the wall; ``line`` and ``parts`` are those of the body's axis in the bore.

    ``position`` of the body's origin (m) and its ``axis`` are in the world frame. A rim's farthest point defines the
    normal, and the normal defines the point; two rounds suffice in a wide bore.
    """
    surfaces, pipe = model.surfaces, model.pipe
    x, r, radius = surfaces[surface, 0], surfaces[surface, 1], surfaces[surface, 2]
    if pipe.shape[0] == 1:
        if is_clear(surfaces, surface, line):
            return 0.0, ZERO, ZERO, x, r
        x, r, contact = surface_contact(surfaces, surface, line)
        lever, normal = lever_and_normal(axis, parts[0], parts[1], contact)
        return max(0.0, contact[0]), lever, normal, x, r
    centre = add(position, scale(x, axis))
    gap, normal = wall_gap(centre, pipe)
    if gap > r + radius:
        return 0.0, ZERO, ZERO, x, r
    if radius > 0.0:
        s = dot(axis, normal)
        if surfaces[surface, 3] <= s <= surfaces[surface, 4]:
            return radius - gap, add(scale(x, axis), scale(radius, normal)), normal, x, 0.0
        x, r = end_of_dome(surfaces, surface, s)
        centre = add(position, scale(x, axis))
        gap, normal = wall_gap(centre, pipe)
    point = farthest_rim_point(centre, axis, r, normal)
    gap, there = wall_gap(point, pipe)
    turned = subtract(there, normal)
    if dot(turned, turned) > ANGLE_TOLERANCE * ANGLE_TOLERANCE:
        point = farthest_rim_point(centre, axis, r, there)
        gap, there = wall_gap(point, pipe)
    return max(0.0, -gap), subtract(point, position), there, x, r


@compiled
def deepest_depth(position: Vector, R: Rotation, model: FlightModel) -> float:
    """Return the depth (m) of the deepest surface of the model in the wall, 0 if none touches."""
    deepest = 0.0
    if not is_far_from_wall(position, model.table[REACH], model.pipe):
        axis = body_axis(R)
        line, parts = axis_line(position, axis, model.pipe), transverse_parts(position, axis, model.pipe)
        for k in range(model.surfaces.shape[0]):
            deepest = max(deepest, surface_depth(position, axis, line, parts, k, model)[0])
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
    bristles = model.bristles.shape[0] // 2
    for k in range(bristles):
        for j in range(3):
            model.bristles[bristles + k, j] = -model.law[FREQUENCY] * model.bristles[k, j]
    if is_far_from_wall(position, model.table[REACH], model.pipe):
        return ZERO, ZERO
    axis, w = body_axis(R), to_world(R, omega)
    line, parts = axis_line(position, axis, model.pipe), transverse_parts(position, axis, model.pipe)
    springs, total, pressed, mass, last, count = (ZERO, ZERO), 0.0, 0.0, 0.0, 0, 0
    for k in range(model.surfaces.shape[0]):
        depth, lever, normal, x, r = surface_depth(position, axis, line, parts, k, model)
        if depth > 0.0:
            mass, energy, force, _ = spring(dot(axis, normal), x, r, depth, model.law)
            total += energy * energy
            pressed += energy * force
            springs = add_wrenches(springs, force_wrench(lever, scale(-energy * force, normal)))
            last, count = k, count + 1
    if not total > 0.0:
        return ZERO, ZERO
    root = math.sqrt(total)
    if count > 1:
        F, T = to_body(R, springs[0]), to_body(R, springs[1])
        a, alpha = multiply(model.table[INVERSE:LINEAR], F, T)
        mass = common_mass(pressed, dot(F, a) + dot(T, alpha), model.law)
    wrench = (ZERO, ZERO)
    for k in range(last if count == 1 else 0, last + 1):
        depth, lever, normal, x, r = surface_depth(position, axis, line, parts, k, model)
        if depth > 0.0:
            moving, s = add(velocity, cross(w, lever)), dot(axis, normal)
            speed = dot(normal, moving)
            _, energy, force, turning = spring(s, x, r, depth, model.law)
            force *= energy / root * damper(root / mass, speed, mass, model.law)
            wrench = add_wrenches(wrench, force_wrench(lever, scale(-force, normal)))
            turn = scale(-turning * energy / (root * smoothed_sine(s)), cross(axis, normal))
            wrench = add_wrenches(wrench, (ZERO, turn))
            if bristles > 0:
                sliding = subtract(moving, scale(speed, normal))
                rub = bristle_force(sliding, normal, model.table[FRICTION] * force, k, model)
                wrench = add_wrenches(wrench, force_wrench(lever, scale(-1.0, rub)))
    return to_body(R, wrench[0]), to_body(R, wrench[1])


@compiled
def bristle_force(sliding: Vector, normal: Vector, most: float, k: int, model: FlightModel) -> Vector:
    """Return the force (N) of surface ``k`` on the wall by friction, at most ``most``, and add it to the bristle's rate.

    ``sliding`` is the velocity along the wall, m/s; see :func:`wall_wrench`.
    """
    bent, mass = (model.bristles[k, 0], model.bristles[k, 1], model.bristles[k, 2]), model.surfaces[k, 6]
    trial = scale(mass * model.law[FREQUENCY], add(sliding, subtract(bent, scale(dot(normal, bent), normal))))
    size = math.sqrt(dot(trial, trial))
    force = trial if size <= most else scale(most / size, trial)
    for j in range(3):
        model.bristles[model.bristles.shape[0] // 2 + k, j] += force[j] / mass
    return force
