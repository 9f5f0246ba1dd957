"""Rims and domes of a body of revolution in a straight bore, in closed form.

e is the unit vector downstream along the bore, a' the unit vector along the body's axis. o and a are the parts
transverse to e of the body's origin (seen from the bore's axis) and of a'. Seen from the axis of the bore, the centre
of the rim (x, r) is at o + x a, and the rim's farthest point along a normal n at o + x a + k (n - (a'.n) a) with
k = r / |n - (a'.n) a'|: again a combination of o and a. A few numbers therefore describe the contact of a rim, and the
vectors are computed once for all rims.
"""

import math
from typing import TypeAlias

from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import Vector, add, dot, scale, subtract

SINE_SMOOTHING = 1e-3
"""Sine of the angle between axis and wall normal below which a rim touches with less than its radius.

A rim that lies flat against the wall touches all around at once: its farthest point is undefined, and the force
passes through its centre.
"""

ANGLE_TOLERANCE = 1e-7
"""Angle (rad) between the wall's normals at a rim's centre and at its contact point that counts as zero."""

AxisLine: TypeAlias = tuple[float, float, float, float]
"""o.o (m2), o.a (m), a.a, and the radius of the bore, m."""

Contact: TypeAlias = tuple[float, float, float, float, float, float]
"""Contact of a surface: depth in the wall (m), normal as factors of o and a, lever as factors of a', o and a."""


@compiled
def transverse_parts(position: Vector, axis: Vector, pipe: FloatArray) -> tuple[Vector, Vector]:
    """Return o (m) and a of a body's origin and ``axis`` in the bore of the first segment, world frame."""
    downstream = (pipe[0, 3], pipe[0, 4], pipe[0, 5])
    off = subtract(position, (pipe[0, 0], pipe[0, 1], pipe[0, 2]))
    o = subtract(off, scale(dot(off, downstream), downstream))
    return o, subtract(axis, scale(dot(axis, downstream), downstream))


@compiled
def axis_line(parts: tuple[Vector, Vector], pipe: FloatArray) -> AxisLine:
    """Return the position in the bore of a body's axis with these ``parts`` o and a.

    The point x of the body's axis is sqrt(o.o + 2 o.a x + a.a x^2) away from the axis of the bore.
    """
    o, a = parts
    return dot(o, o), dot(o, a), dot(a, a), pipe[0, 7]


@compiled
def smoothed_sine(s: float) -> float:
    """Return |n - (a'.n) a'| for s = a'.n, where n is a unit vector; see :data:`SINE_SMOOTHING`."""
    return math.sqrt(max(0.0, 1.0 - s * s) + SINE_SMOOTHING * SINE_SMOOTHING)


@compiled
def is_clear(surfaces: FloatArray, k: int, line: AxisLine) -> bool:
    """Return True if surface ``k`` certainly does not touch the bore; a quick test that some clear rims fail.

    A rim's centre is at d from the axis, and the rim extends r sqrt(1 - s^2) further, where s is the component of
    the body's axis along d. Neither root is computed: d <= (d^2 + R^2) / (2 R), and s d = o.a + a.a x.
    """
    oo, oa, aa, R = line
    x, r = surfaces[k, 0], surfaces[k, 1]
    slope = oa + aa * x
    square = oo + (oa + slope) * x
    if surfaces[k, 2] > 0.0:
        room = R - surfaces[k, 2]
        return bool(room > 0.0 and square < room * room)
    room = 0.5 * R - 0.5 * square / R - surfaces[k, 5] if R > 0.0 else 0.0
    return room > 0.0 and r * r * (square - slope * slope) < room * room * square


@compiled
def surface_contact(surfaces: FloatArray, k: int, line: AxisLine) -> tuple[float, float, Contact]:
    """Return the rim (x, r) that touches (of a dome, its centre), m, and its contact with the bore.

    The depth is negative if the surface is clear.
    """
    x, r, radius = surfaces[k, 0], surfaces[k, 1], surfaces[k, 2]
    if radius == 0.0:
        return x, r, rim_contact(x, r, line)
    oo, oa, aa, R = line
    square = oo + (2.0 * oa + aa * x) * x
    if not square > 0.0:
        return x, r, (radius - R, 0.0, 0.0, x, 0.0, 0.0)
    far = math.sqrt(square)
    s = (oa + aa * x) / far
    if s < surfaces[k, 3] or s > surfaces[k, 4]:
        x, r = end_of_dome(surfaces, k, s)
        return x, r, rim_contact(x, r, line)
    return x, r, (far + radius - R, 1.0 / far, x / far, x, radius / far, radius * x / far)


@compiled
def end_of_dome(surfaces: FloatArray, k: int, s: float) -> tuple[float, float]:
    """Return the rim (x, r), m, at the end of a dome whose normals end before the component ``s`` along the axis."""
    s = min(max(s, surfaces[k, 3]), surfaces[k, 4])
    return surfaces[k, 0] + surfaces[k, 2] * s, surfaces[k, 2] * math.sqrt(max(0.0, 1.0 - s * s))


@compiled
def rim_contact(x: float, r: float, line: AxisLine) -> Contact:
    """Return the contact of the rim (x, r) with the bore; the depth is negative if the rim is clear.

    The farthest point defines the normal, and the normal defines the point; two rounds suffice in a wide bore.
    """
    oo, oa, aa, R = line
    square = oo + (2.0 * oa + aa * x) * x
    if not square > 0.0:
        return -R, 0.0, 0.0, x, 0.0, 0.0
    far = math.sqrt(square)
    # The normal is n_o o + n_a a; the rim's farthest point is p_o o + p_a a from the axis of the bore.
    n_o, n_a = 1.0 / far, x / far
    s, k, p_o, p_a, far = _farthest_point(x, r, n_o, n_a, line)
    cosine = (n_o * (p_o * oo + p_a * oa) + n_a * (p_o * oa + p_a * aa)) / far
    if 2.0 - 2.0 * cosine > ANGLE_TOLERANCE * ANGLE_TOLERANCE:
        n_o, n_a = p_o / far, p_a / far
        s, k, p_o, p_a, far = _farthest_point(x, r, n_o, n_a, line)
    return far - R, p_o / far, p_a / far, x - k * s, k * n_o, k * n_a


@compiled
def _farthest_point(
    x: float, r: float, n_o: float, n_a: float, line: AxisLine
) -> tuple[float, float, float, float, float]:
    """Return a'.n, k, the rim's farthest point along n as factors of o and a, and its distance from the bore's axis."""
    oo, oa, aa, _ = line
    s = n_o * oa + n_a * aa
    k = r / smoothed_sine(s)
    p_o, p_a = 1.0 + k * n_o, x + k * (n_a - s)
    return s, k, p_o, p_a, math.sqrt(p_o * p_o * oo + 2.0 * p_o * p_a * oa + p_a * p_a * aa)


@compiled
def lever_and_normal(axis: Vector, o: Vector, a: Vector, contact: Contact) -> tuple[Vector, Vector]:
    """Return the point of contact, seen from the body's origin (m), and the wall's normal there; world frame."""
    _, n_o, n_a, along, l_o, l_a = contact
    return (add(scale(along, axis), add(scale(l_o, o), scale(l_a, a))), add(scale(n_o, o), scale(n_a, a)))
