"""Compiled code: integrals over rings, and the equations at all collocation points.

All compiled functions are in this file, because the cache of a function detects no changes of other files of this plugin.

Green's identity for the potential phi outside a body, with the normal n into the water, on its surface:

    2 pi phi(x) - int phi(x') d(1/R)/dn' dS' = - int (1/R) dphi/dn' dS'        R = |x - x'|

On a body of revolution phi = phi_m(s) cos(m theta), and the integral over theta is done in closed form: a ring of
radius r' acts on the point (x, r) of the meridian by complete elliptic integrals. Surge has m = 0, sway and yaw have
m = 1. The equations hold in any unit of length.
"""

import math

import numpy as np

from driftform.types import FloatArray
from driftform.util import compiled, vectorized

NODES = 3
"""Values of the potential on each panel, at Gauss's points of the panel's parameter."""

FAR = 3.0
"""Distance of a panel's middle, in panel lengths, beyond which these points suffice for quadrature."""

NEAR = 0.8
"""Distance of a piece's middle, in lengths of the piece, beyond which eight points suffice."""

MIN_PIECE = 1e-3
"""Length of the shortest piece, relative to its panel."""

_MAX_PIECES = 48
_EIGHT = 8

_x, _w = np.polynomial.legendre.leggauss(NODES)
POINTS, WEIGHTS = (_x + 1) / 2, _w / 2
_x, _w = np.polynomial.legendre.leggauss(_EIGHT)
_POINTS_8, _WEIGHTS_8 = (_x + 1) / 2, _w / 2
_BASIS = np.linalg.inv(np.vander(POINTS)).T.copy()
"""Row k holds the quadratic that is 1 at the k-th point and 0 at the others, highest power first."""


@compiled
def _ring_integrals(dx: float, r: float, s: float) -> tuple[float, float]:
    """Return I0 and I1 / I0, with I_m = int cos(m theta) / R over the ring, R^2 = dx^2 + r^2 + s^2 - 2 r s cos(theta).

    They are complete elliptic integrals, found by their arithmetic-geometric mean (Abramowitz & Stegun, 17.6). Let
    a_0^2 = dx^2 + (r + s)^2, b_0^2 = dx^2 + (r - s)^2, p = 2 r s, and c_n = (a_{n-1} - b_{n-1}) / 2 the half
    differences of the steps n = 1, 2, ... to the mean M. Then

        I0 = 4 K / a_0 = 2 pi / M,    I1 = ((a_0^2 - p) I0 - 4 a_0 E) / p = I0 (c_1^2 + 2 c_2^2 + 4 c_3^2 + ...) / p

    so that no difference of K and E is computed: the result is exact to rounding on the axis, far away, and near the
    ring for b_0 > 1e-6 a_0.
    """
    p = 2.0 * r * s
    a = math.sqrt(dx * dx + (r + s) * (r + s))
    g = math.sqrt(dx * dx + (r - s) * (r - s))
    c = p / (a + g)
    total = c * c
    weight = 1.0
    for _ in range(6):
        mean = 0.5 * (a + g)
        g = math.sqrt(a * g)
        a = mean
        weight *= 2.0
        c = 0.5 * (a - g)
        total += weight * c * c
    return 4.0 * math.pi / (a + g), total / p


@compiled
def integrate_rings(x: float, r: float, source: FloatArray, count: int, out: FloatArray) -> None:
    """Compute the influence of rings on one point of the meridian; the loop is compiled to vector instructions.

    Args:
        x, r: the point, r > 0.
        source: x', r' > 0 of each ring, and the normal's components n_x, n_r times its width, (4, n).
        count: number of rings.
        out: receives the influence of each ring, (5, n): the single layers r' I0 n_x, r' I1 n_r and r' I1 (x' n_r -
            r' n_x) of surge, sway and yaw, and the double layers of m = 0 and m = 1, r' [n_x (x - x') J_m + n_r (r
            J_{m+1} - r' J_m)], with J_m the integral of cos(theta)^m / R^3.
    """
    for k in range(count):
        s, nx, nr = source[1, k], source[2, k], source[3, k]
        dx = x - source[0, k]
        i0, ratio = _ring_integrals(dx, r, s)
        i0 *= s
        i1 = i0 * ratio
        p = 2.0 * r * s
        square = dx * dx + r * r + s * s
        scaled = i0 / (square + p)
        # J0 = I0 (A - p q) / (a b)^2 and J1 = I0 (p - A q) / (a b)^2, with A = square and q = ratio. The distance
        # from the ring's tangent plane holds the singularity; that of J0 - J1 and J1 - J2 is only logarithmic.
        plane = (nx * dx + nr * (r - s)) / (dx * dx + (r - s) * (r - s))
        turned = nr * r
        out[0, k] = i0 * nx
        out[1, k] = i1 * nr
        out[2, k] = i1 * (source[0, k] * nr - s * nx)
        out[3, k] = scaled * (plane * (square - p * ratio) - turned * (1.0 + ratio))
        out[4, k] = scaled * (plane * (p - square * ratio) - turned * ((2.0 * square + p) * (ratio / p) - 1.0))


@compiled
def _evaluate(curve: FloatArray, u: float) -> float:
    return float(((curve[0] * u + curve[1]) * u + curve[2]) * u + curve[3])


@compiled
def _slope(curve: FloatArray, u: float) -> float:
    return float((3.0 * curve[0] * u + 2.0 * curve[1]) * u + curve[2])


@compiled
def _place_ring(x: FloatArray, r: FloatArray, u: float, weight: float, source: FloatArray, k: int) -> None:
    """Place a ring at the point u of a panel, with its weight in a quadrature over u."""
    source[0, k] = _evaluate(x, u)
    source[1, k] = _evaluate(r, u)
    source[2, k] = -weight * _slope(r, u)
    source[3, k] = weight * _slope(x, u)


@compiled
def _choose_points_around(u: float, points: FloatArray, weights: FloatArray) -> int:
    """Choose points and weights for a panel whose integrand is logarithmic at u; return their number.

    On either side the distance from u is the cube of the variable of Gauss's rule, which makes the integrand smooth
    enough.
    """
    count = 0
    for side in range(2):
        for k in range(_EIGHT):
            t = _POINTS_8[k]
            points[count] = u + (side - u) * t * t * t
            weights[count] = abs(side - u) * 3.0 * t * t * _WEIGHTS_8[k]
            count += 1
    return count


@compiled
def _choose_points_beside(
    xi: float, ri: float, x: FloatArray, r: FloatArray, length: float, points: FloatArray, weights: FloatArray
) -> int:
    """Choose points and weights for a panel near the point (xi, ri); return their number.

    The panel is cut into pieces, which are shorter near the point.
    """
    count, start = 0, 0.0
    while start < 1.0:
        piece = 1.0 - start
        if count + 2 * _EIGHT <= len(points):
            while piece > MIN_PIECE:
                middle = start + 0.5 * piece
                if math.hypot(xi - _evaluate(x, middle), ri - _evaluate(r, middle)) >= NEAR * piece * length:
                    break
                piece *= 0.5
        for k in range(_EIGHT):
            points[count] = start + piece * _POINTS_8[k]
            weights[count] = piece * _WEIGHTS_8[k]
            count += 1
        start += piece
    return count


@vectorized
def assemble_equations(x: FloatArray, r: FloatArray, lengths: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Set up the equations of m = 0 and m = 1 at the collocation points, three on each panel.

    Far panels are integrated by Gauss's rule at the nodes of the potential, for which the interpolation drops out; near
    panels by eight points on each piece; the point's own panel with a substitution that removes the logarithm (the panel
    is so nearly straight that D has no stronger singularity there). A constant potential of 1 has no flow, so a row of
    D_0 must sum to -2 pi, and the remainder is added to the diagonal. For m = 1 no such row sum exists: the potential
    whose flow is known, r cos(theta), is not a polynomial in the parameter of a panel. D_1 is not corrected.

    Args:
        x, r: the panels' curves: polynomials in u from 0 to 1, highest power first, (panels, 4).
        lengths: lengths of the panels, (panels,).

    Returns:
        matrices: 2 pi - D_0 and 2 pi - D_1, (2, n, n).
        sides: right-hand sides of surge (m = 0), sway, and yaw about x = 0 (m = 1), (n, 3).
        nodes: x, r, n_x, n_r at the collocation points, the normal times the quadrature weight along the arc, (4, n).
    """
    panels = len(lengths)
    n = NODES * panels
    matrices, sides = np.empty((2, n, n)), np.empty((n, 3))
    nodes, far = np.empty((4, n)), np.empty((5, n))
    size = _EIGHT * _MAX_PIECES
    points, weights, source, near = np.empty(size), np.empty(size), np.empty((4, size)), np.empty((5, size))
    for j in range(panels):
        for k in range(NODES):
            _place_ring(x[j], r[j], POINTS[k], WEIGHTS[k], nodes, NODES * j + k)
    for i in range(n):
        xi, ri = nodes[0, i], nodes[1, i]
        integrate_rings(xi, ri, nodes, n, far)
        surge, sway, yaw, row = 0.0, 0.0, 0.0, 0.0
        for j in range(panels):
            first = NODES * j
            u = POINTS[i - first] if i // NODES == j else -1.0
            if u < 0.0 and (math.hypot(xi - _evaluate(x[j], 0.5), ri - _evaluate(r[j], 0.5)) >= FAR * lengths[j]):
                for k in range(first, first + NODES):
                    surge += far[0, k]
                    sway += far[1, k]
                    yaw += far[2, k]
                    row += far[3, k]
                    matrices[0, i, k] = -far[3, k]
                    matrices[1, i, k] = -far[4, k]
                continue
            if u >= 0.0:
                count = _choose_points_around(u, points, weights)
            else:
                count = _choose_points_beside(xi, ri, x[j], r[j], lengths[j], points, weights)
            for k in range(count):
                _place_ring(x[j], r[j], points[k], weights[k], source, k)
            integrate_rings(xi, ri, source, count, near)
            for m in range(NODES):
                matrices[0, i, first + m] = 0.0
                matrices[1, i, first + m] = 0.0
            for k in range(count):
                surge += near[0, k]
                sway += near[1, k]
                yaw += near[2, k]
                row += near[3, k]
                for m in range(NODES):
                    share = (_BASIS[m, 0] * points[k] + _BASIS[m, 1]) * points[k] + _BASIS[m, 2]
                    matrices[0, i, first + m] -= share * near[3, k]
                    matrices[1, i, first + m] -= share * near[4, k]
        matrices[0, i, i] += 2.0 * math.pi + (2.0 * math.pi + row)
        matrices[1, i, i] += 2.0 * math.pi
        sides[i, 0], sides[i, 1], sides[i, 2] = -surge, -sway, -yaw
    return matrices, sides, nodes
