"""Rims of a body of revolution in a straight bore, in closed form.

With e downstream along the bore, let o and a be the parts across e of the body's origin (seen from the bore's axis)
and of the body's axis. The centre of the rim (x, r) is at o + x a from the axis of the bore, and the rim's farthest
point along a normal n at o + x a + k (n - (a.n) a) with k = r / |n - (a.n) a'|, a' being the whole of the body's
axis: again some combination of o and a. So all there is to know of a rim that touches is a handful of numbers, and
vectors are made once for all rims.
"""

import math
from typing import TypeAlias

from driftform.dynamics.vectors import Vector, add, cross, dot, scale, subtract
from driftform.types import FloatArray
from driftform.util.compiled import compiled

BLUNT = 1e-3
"""Sine of the angle between axis and wall normal below which a rim touches with less than its radius.

A rim that faces the wall flatly touches all around at once; its lowest point is then undefined, and the force
passes through its centre.
"""

SETTLED = 1e-7
"""Angle (rad) between the wall's normal at the centre of a rim and at its contact point that makes no difference."""

Line: TypeAlias = tuple[float, float, float, float]
"""o.o, o.a, a.a (m2, m, 1), and the radius of the bore, m."""

Basis: TypeAlias = tuple[Vector, Vector, Vector, Vector, Vector]
"""o, a, and the products a' x o, a' x a, o x a, in the world frame; a' is the whole of the body's axis."""

Touch: TypeAlias = tuple[float, float, float, float, float, float]
"""Of a rim: its depth in the wall (m), the normal there as factors of o and a, its lever as factors of a', o and a."""


@compiled
def axis_line(position: Vector, axis: Vector, pipe: FloatArray) -> Line:
    """Return where the body's ``axis`` runs in the bore: a point at x of it is sqrt(o.o + 2 o.a x + a.a x^2) off.

    The radius is 0 where the pipe has more than one segment, and the distance is no such simple thing.
    """
    if pipe.shape[0] != 1:
        return 0.0, 0.0, 0.0, 0.0
    o, a = across(position, axis, pipe)
    return dot(o, o), dot(o, a), dot(a, a), pipe[0, 7]


@compiled
def basis(position: Vector, axis: Vector, pipe: FloatArray) -> Basis:
    """Return the vectors that normals, levers and torques in a straight bore are made of."""
    o, a = across(position, axis, pipe)
    return o, a, cross(axis, o), cross(axis, a), cross(o, a)


@compiled
def across(position: Vector, axis: Vector, pipe: FloatArray) -> tuple[Vector, Vector]:
    """Return o and a in the bore of the first segment, world frame."""
    downstream = (pipe[0, 3], pipe[0, 4], pipe[0, 5])
    off = subtract(position, (pipe[0, 0], pipe[0, 1], pipe[0, 2]))
    o = subtract(off, scale(dot(off, downstream), downstream))
    return o, subtract(axis, scale(dot(axis, downstream), downstream))


@compiled
def blunt(s: float) -> float:
    """Return |n - (a'.n) a'| for s = a'.n, with n a unit vector; see :data:`BLUNT`."""
    return math.sqrt(max(0.0, 1.0 - s * s) + BLUNT * BLUNT)


@compiled
def is_coplanar(line: Line, reach: float) -> bool:
    """Return True where the axes of body and bore lie in one plane, and no rim within ``reach`` (m) is beyond the bore's.

    The wall's normal is then the same for every rim, up to :data:`SETTLED`.
    """
    oo, oa, aa, _ = line
    apart, nearest = (oo * aa - oa * oa) * reach * reach, oo - abs(oa) * reach
    return nearest > 0.0 and apart < SETTLED * SETTLED * nearest * nearest


@compiled
def is_clear(rims: FloatArray, k: int, line: Line) -> bool:
    """Return True where rim ``k`` surely does not touch the bore.

    Its centre is at d from the axis, and it reaches out by r sqrt(1 - s^2), s being the component of the
    body's axis along d. Neither root is taken: d <= (d^2 + R^2) / (2 R), and s d = o.a + a.a x.
    """
    oo, oa, aa, R = line
    x, r = rims[k, 0], rims[k, 1]
    slope = oa + aa * x
    square = oo + (oa + slope) * x
    room = 0.5 * R - 0.5 * square / R - rims[k, 5] if R > 0.0 else 0.0
    return room > 0.0 and r * r * (square - slope * slope) < room * room * square


@compiled
def touch(x: float, r: float, line: Line) -> Touch:
    """Return how the rim (x, r) touches the bore; its depth is negative where it does not.

    The farthest point defines the normal and the normal the point; the bore is wide, so two rounds settle.
    """
    oo, oa, aa, R = line
    square = oo + (2.0 * oa + aa * x) * x
    if not square > 0.0:
        return -R, 0.0, 0.0, x, 0.0, 0.0
    far = math.sqrt(square)
    # The normal is n_o o + n_a a, the rim's point p_o o + p_a a from the axis of the bore.
    n_o, n_a = 1.0 / far, x / far
    s, k, p_o, p_a, far = _point(x, r, n_o, n_a, line)
    cosine = (n_o * (p_o * oo + p_a * oa) + n_a * (p_o * oa + p_a * aa)) / far
    if 2.0 - 2.0 * cosine > SETTLED * SETTLED:
        n_o, n_a = p_o / far, p_a / far
        s, k, p_o, p_a, far = _point(x, r, n_o, n_a, line)
    return far - R, p_o / far, p_a / far, x - k * s, k * n_o, k * n_a


@compiled
def _point(
    x: float, r: float, n_o: float, n_a: float, line: Line
) -> tuple[float, float, float, float, float]:
    """Return a'.n, k, the rim's farthest point along n as factors of o and a, and its distance from the bore's axis."""
    oo, oa, aa, _ = line
    s = n_o * oa + n_a * aa
    k = r / blunt(s)
    p_o, p_a = 1.0 + k * n_o, x + k * (n_a - s)
    return s, k, p_o, p_a, math.sqrt(p_o * p_o * oo + 2.0 * p_o * p_a * oa + p_a * p_a * aa)


@compiled
def lever_and_normal(axis: Vector, o: Vector, a: Vector, touching: Touch) -> tuple[Vector, Vector]:
    """Return where a rim touches, seen from the body's origin, and the wall's normal there; world frame."""
    _, n_o, n_a, along, l_o, l_a = touching
    return (
        add(scale(along, axis), add(scale(l_o, o), scale(l_a, a))),
        add(scale(n_o, o), scale(n_a, a)),
    )
