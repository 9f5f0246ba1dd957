"""The ideal flow in a tee or wye: the gradient of a potential, twice continuously differentiable.

A tee is described in its local frame: the axes meet at the origin, x runs downstream along the run, and the branch leaves
along (cos A, 0, sin A). The potential is a sum of two, :class:`driftform.water.parts.tee_store.TeePotentials`, made once for each shape.
"""

import math
from functools import lru_cache

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import Rotation, Vector
from driftform.water.parts.tee_spline import HEAD, LEVEL_SIZE, potential_derivatives
from driftform.water.parts.tee_store import load_tee
from driftform.water.parts.tee_wall import Junction, wall_level
from driftform.water.parts.walls import COSINE, DOWNSTREAM, END_RADIUS, PART, SIDE, SINE, UPSTREAM

MIN_BRANCH, MAX_FILLET, MIN_FILLET = 0.2, 0.5, 0.1
"""Limits of the branch's radius over that of the run, and of the fillet over the branch's radius."""

MIN_ANGLE, MAX_ANGLE = math.radians(30), math.radians(150)

RADIUS, MIRRORED, WALL = 0, 1, 2
"""Indices in the array of a field: radius of the run (m), -1 if x is mirrored, otherwise 1, and the wall; then the potential."""

_SPLINE = WALL + PART


@lru_cache(maxsize=16)
def tee_field(radius: float, branch: float, angle: float, fillet: float, Q2: float, Q3: float) -> FloatArray:
    """Return the flow in a tee as :func:`tee_motion` reads it, (n,), read-only.

    Args:
        radius, branch: radii of run and branch, m; the branch has between 0.2 and 1 times the radius of the run.
        angle: of the branch from the downstream direction of the run, 30 to 150 degrees, rad.
        fillet: radius of the rounded edge, m; between 0.1 and 0.5 times the radius of the branch.
        Q2, Q3: volume flow that leaves by the run and by the branch, m3/s; a negative one enters there.

    Raises ValueError if the shape is outside these limits.
    """
    junction, mirrored = _find_junction(radius, branch, angle, fillet)
    tee = load_tee(junction)
    through, side = Q2 / (math.pi * radius**2), Q3 / (math.pi * radius**2)
    if mirrored:
        # The water enters at the mirror image's outlet.
        through = -through - side
    field = pack_field(radius, mirrored, junction, tee.head, radius * (through * tee.through + side * tee.branch))
    field.flags.writeable = False
    return field


def pack_field(
    radius: float, mirrored: bool, junction: Junction, head: FloatArray, potential: FloatArray
) -> FloatArray:
    """Return the flow with a potential as :func:`tee_motion` reads it, (n,); ``head`` says where its cells are."""
    head = head.copy()
    head[HEAD + LEVEL_SIZE - 1 :: LEVEL_SIZE] += _SPLINE
    return np.concatenate([[radius, -1.0 if mirrored else 1.0], junction.array(), head, potential])


def _find_junction(radius: float, branch: float, angle: float, fillet: float) -> tuple[Junction, bool]:
    """Return the shape in units of the run's radius, and whether its mirror image has the angle."""
    _check_shape(branch / radius, angle, fillet / branch)
    mirrored = angle > math.pi / 2 + 1e-9
    # Digits that differ by rounding must not make another shape.
    turn = round(math.degrees(math.pi - angle if mirrored else angle), 7)
    return Junction(round(branch / radius, 9), math.radians(turn), round(fillet / radius, 9)), mirrored


def _check_shape(branch: float, angle: float, fillet: float) -> None:
    if not MIN_BRANCH - 1e-9 <= branch <= 1 + 1e-9:
        raise ValueError(
            f"a branch with {branch:.3g} times the radius of the run: the flow in tees is known from {MIN_BRANCH:g} to 1"
        )
    if not MIN_ANGLE - 1e-9 <= angle <= MAX_ANGLE + 1e-9:
        raise ValueError(
            f"a branch at {math.degrees(angle):.4g} degrees: the flow in tees is known from 30 to 150 degrees"
        )
    if not MIN_FILLET - 1e-9 <= fillet <= MAX_FILLET + 1e-9:
        raise ValueError(
            f"a fillet of {fillet:.3g} times the radius of the branch: the flow in tees is known from {MIN_FILLET:g} to "
            f"{MAX_FILLET:g}, and a sharp edge would have an infinite speed"
        )


@compiled
def tee_motion(point: Vector, field: FloatArray) -> tuple[Vector, Rotation]:
    """Return the velocity of the water (m/s) and its gradient du_i/dx_j (rows i, 1/s) at a point (m) of the local frame.

    A point in the wall has the velocity of the nearest point on its surface, one beyond an end that at the end.
    """
    radius, side = field[RADIUS], field[MIRRORED]
    wall = field[WALL : WALL + PART]
    x, y, z = _keep_in_water(side * point[0] / radius, point[1] / radius, point[2] / radius, wall)
    d = potential_derivatives(x, y, z, field, _SPLINE)
    # Rounding may leave a point on the wall in a cell without water: the next attempts lie further inside.
    for _ in range(8):
        if not math.isnan(d[0]):
            break
        _, n = wall_level(x, y, z, wall)
        x, y, z = x - 0.01 * n[0], y - 0.01 * n[1], z - 0.01 * n[2]
        d = potential_derivatives(x, y, z, field, _SPLINE)
    if math.isnan(d[0]):
        # So far outside, no flight needs a better answer than the velocity where the axes meet.
        d = potential_derivatives(0.0, 0.0, 0.0, field, _SPLINE)
    one, two = 1.0 / radius, 1.0 / (radius * radius)
    return (
        (one * side * d[0], one * d[1], one * d[2]),
        (
            (two * d[3], two * side * d[4], two * side * d[5]),
            (two * side * d[4], two * d[6], two * d[7]),
            (two * side * d[5], two * d[7], two * d[8]),
        ),
    )


@compiled
def _keep_in_water(x: float, y: float, z: float, wall: FloatArray) -> Vector:
    """Return the nearest point in the water, between the ends."""
    x = min(max(x, -wall[UPSTREAM]), wall[DOWNSTREAM] - 1e-9)
    beyond = x * wall[COSINE] + z * wall[SINE] - wall[SIDE] + 1e-9
    if beyond > 0.0 and y * y + z * z > 1.0:
        x, z = x - beyond * wall[COSINE], z - beyond * wall[SINE]
    for _ in range(3):
        # In the bores no search for the wall is needed.
        across = x * wall[SINE] - z * wall[COSINE]
        along = x * wall[COSINE] + z * wall[SINE]
        if y * y + z * z <= 1.0 or (along >= 0.0 and across * across + y * y <= wall[END_RADIUS] * wall[END_RADIUS]):
            break
        depth, n = wall_level(x, y, z, wall)
        if depth <= 0.0:
            break
        x, y, z = x - depth * n[0], y - depth * n[1], z - depth * n[2]
    return x, y, z
