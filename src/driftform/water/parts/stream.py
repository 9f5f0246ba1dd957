r"""The mean flow in a pipe with parts: velocity profiles in straights, ideal flow in fittings.

Bends have the free vortex, reducers plug flow by the area law, tees the ideal flow of :mod:`driftform.water.parts.tee_flow`. Fittings meet
each other, and the straights shorter than a diameter between them, in plug flow. Longer straights carry the profile of
``flow.kind``, and change over to the flow of the fitting at each end within a length l <= 2 R. With the weights w of the
fittings' flows, c = 1 - sum of w, the mean speed U, the profile's excess D_p(r) and the vortex's excess D over U::

    u = U + c D_p + w D        v = -c' grad(phi_p) - w' grad(phi)        laplacian(phi) = D

along and across the axis: free of divergence, tangential to the wall, and with the exact flux at every section. The weights are
quintic steps, so that velocity and gradient are continuous. A bend between two fittings changes from plug flow to the
vortex and back in the same way.
"""

import math

from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import ZERO, Rotation, Vector
from driftform.water.parts.bends import DECAY, crossing_potential, dean_cells, vortex_excess
from driftform.water.parts.profiles import (
    LOG_LAW,
    MIN_WALL_DISTANCE,
    PARABOLA,
    POWER_LAW,
    UNIFORM,
    Bore,
    Spread,
    spread_across,
    spread_profile,
)
from driftform.water.parts.tee_flow import tee_motion
from driftform.water.parts.walls import (
    ANGLE,
    BEND,
    CURVE,
    EDGE,
    EDGE_POINTS,
    END_RADIUS,
    FIELD,
    FIELD_SIZE,
    KIND,
    LENGTH,
    RADIUS,
    REDUCER,
    TEE,
    beyond_bores,
    find_part,
    fitting_gap,
    to_part,
    turn_from_part,
    turn_to_part,
)

# Indices in a row of `fittings`; see walls.
SPEED, PARAMETER, DEVELOPED = 30, 31, 32
"""Mean speed (m/s) at the entry, parameter of the profile, and 1 for a straight that carries the profile."""
START, FINISH = 33, 38
"""Changes of the flow at the ends, five numbers each: length (m; of a bend: rad), 0 for none, and the vortex beyond it."""
LONG, AMPLITUDE, AROUND, TOWARD_Y, TOWARD_Z = 0, 1, 2, 3, 4
"""The vortex: its share, radius of the bend (m), and the direction to the bend's centre in the local frame."""
PROFILE, FRICTION = 44, 45
"""The profile, and the friction velocity at the entry, m/s."""
STRENGTH = 43
"""Share of the free vortex in a bend: less than 1 where a short bend between fittings has no room for it."""


SWIRL = EDGE + 3 * EDGE_POINTS
"""Secondary flow on the axis over the mean speed: of a bend at its end, of a straight at its start; negative in a bend that has
no straight after it, where it comes and goes."""


@compiled
def fitting_flow(point: Vector, f: FloatArray, spread: Spread) -> tuple[Vector, Rotation]:
    """Return the velocity of the mean flow (m/s) and its gradient du_i/dx_j (rows i, 1/s), in the world frame.

    ``spread`` is that of the body: see :func:`driftform.water.velocity.water_motion`.
    """
    o, _ = find_part(point, f)
    p = to_part(point, f, o)
    part = f[o + KIND]
    if part == BEND:
        velocity, gradient = _flow_in_bend(p, f, o)
    elif part == REDUCER:
        velocity, gradient = _flow_in_reducer(p, f, o)
    elif part == TEE:
        start = int(f[o + FIELD])
        velocity, gradient = tee_motion(p, f[start : start + int(f[o + FIELD_SIZE])])
    else:
        axis = turn_to_part(spread[0], f, o)
        square = spread_across((axis, spread[1], spread[2]), (1.0, 0.0, 0.0))
        velocity, gradient = _flow_in_straight(p, f, o, square)
    return turn_from_part(velocity, f, o), _turn_gradient(gradient, f, o)


@compiled
def _turn_gradient(gradient: Rotation, f: FloatArray, o: int) -> Rotation:
    """Return a gradient of the local frame of a part in the world frame."""
    a, b, c = (turn_from_part(gradient[0], f, o), turn_from_part(gradient[1], f, o), turn_from_part(gradient[2], f, o))
    x = turn_from_part((a[0], b[0], c[0]), f, o)
    y = turn_from_part((a[1], b[1], c[1]), f, o)
    z = turn_from_part((a[2], b[2], c[2]), f, o)
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])


@compiled
def rise(t: float) -> Vector:
    """Return the quintic step 10 t^3 - 15 t^4 + 6 t^5 from 0 to 1, and its two derivatives."""
    if t <= 0.0:
        return ZERO
    if t >= 1.0:
        return 1.0, 0.0, 0.0
    back = 1.0 - t
    return (t * t * t * (10.0 - 15.0 * t + 6.0 * t * t), 30.0 * t * t * back * back, 60.0 * t * back * (1.0 - 2.0 * t))


@compiled
def _flow_in_straight(p: Vector, f: FloatArray, o: int, square: float) -> tuple[Vector, Rotation]:
    kind, U, R, c, slope, bend = f[o + PROFILE], f[o + SPEED], f[o + RADIUS], f[o + DEVELOPED], 0.0, 0.0
    u, u_x, u_y, u_z = U, 0.0, 0.0, 0.0
    v_y, v_z, a_y, a_z = 0.0, 0.0, 0.0, 0.0
    yy, yz, zz = 0.0, 0.0, 0.0
    r = math.hypot(p[1], p[2])
    for end in range(2):
        e = o + (START if end == 0 else FINISH)
        length = f[e + LONG]
        if length == 0.0:
            continue
        sign = -1.0 if end == 0 else 1.0
        along = p[0] if end == 0 else f[o + LENGTH] - p[0]
        w, w1, w2 = rise(1.0 - along / length)
        w1, w2 = sign * w1 / length, w2 / (length * length)
        c, slope, bend = c - w, slope - w1, bend - w2
        share = f[e + AMPLITUDE]
        if share == 0.0 or w == 0.0:
            continue
        # Within the bore: a point in the wall has the flow at the wall.
        inside = min(1.0, R / r) if r > 0.0 else 1.0
        y, z = inside * p[1], inside * p[2]
        m, n = f[e + TOWARD_Y], f[e + TOWARD_Z]
        D, D1 = vortex_excess(m * y + n * z, f[e + AROUND], R, U)
        (phi1, phi2), (phi11, phi12) = crossing_potential(m * y + n * z, m * z - n * y, f[e + AROUND], R, U)
        phi22 = D - phi11
        w, w1, w2 = share * w, share * w1, share * w2
        u, u_x, u_y, u_z = u + w * D, u_x + w1 * D, u_y + w * D1 * m, u_z + w * D1 * n
        phi_y, phi_z = m * phi1 - n * phi2, n * phi1 + m * phi2
        v_y, v_z, a_y, a_z = v_y - w1 * phi_y, v_z - w1 * phi_z, a_y - w2 * phi_y, a_z - w2 * phi_z
        yy -= w1 * (m * m * phi11 - 2.0 * m * n * phi12 + n * n * phi22)
        yz -= w1 * (m * n * (phi11 - phi22) + (m * m - n * n) * phi12)
        zz -= w1 * (n * n * phi11 + 2.0 * m * n * phi12 + m * m * phi22)
    if kind != UNIFORM and f[o + DEVELOPED] != 0.0:
        n_y, n_z = (p[1] / r, p[2] / r) if r > 0.0 else (0.0, 0.0)
        full, shear, _, _ = spread_profile(R, 0.0, r, square, kind, U, f[o + PARAMETER])
        excess, radial = _profile_excess(r, R, kind, U, f[o + PARAMETER])
        u, u_x = u + c * (full - U), u_x + slope * (full - U)
        u_y, u_z = u_y + c * shear * n_y, u_z + c * shear * n_z
        if slope != 0.0:
            ring = radial / r if r > 0.0 else 0.5 * excess
            v_y, v_z = v_y - slope * radial * n_y, v_z - slope * radial * n_z
            a_y, a_z = a_y - bend * radial * n_y, a_z - bend * radial * n_z
            steep = excess - 2.0 * ring
            yy -= slope * (ring + steep * n_y * n_y)
            yz -= slope * steep * n_y * n_z
            zz -= slope * (ring + steep * n_z * n_z)
    zy = yz
    if f[o + SWIRL] != 0.0:
        inside = min(1.0, R / r) if r > 0.0 else 1.0
        m, n, y, z = f[o + START + TOWARD_Y], f[o + START + TOWARD_Z], inside * p[1], inside * p[2]
        (out, up), (xx, xe, ex, ee) = dean_cells(m * y + n * z, m * z - n * y, R)
        far = DECAY * R
        # It ends with the straight.
        room = min(2.0 * R, 0.5 * f[o + LENGTH])
        w, w1, _ = rise((f[o + LENGTH] - p[0]) / room)
        left = 1.0 / math.cosh(p[0] / far)
        A, A1 = (U * f[o + SWIRL] * left * w, -U * f[o + SWIRL] * left * (w * math.tanh(p[0] / far) / far + w1 / room))
        w_y, w_z = m * out - n * up, n * out + m * up
        v_y, v_z, a_y, a_z = v_y + A * w_y, v_z + A * w_z, a_y + A1 * w_y, a_z + A1 * w_z
        yy += A * (m * m * xx - m * n * (xe + ex) + n * n * ee)
        yz += A * (m * n * (xx - ee) + m * m * xe - n * n * ex)
        zy += A * (m * n * (xx - ee) + m * m * ex - n * n * xe)
        zz += A * (n * n * xx + m * n * (xe + ex) + m * m * ee)
    return (u, v_y, v_z), ((u_x, u_y, u_z), (a_y, yy, yz), (a_z, zy, zz))


@compiled
def _profile_excess(r: float, R: float, kind: float, U: float, parameter: float) -> tuple[float, float]:
    """Return the profile's excess D_p (m/s) over the mean speed, and (1/r) times the integral of D_p r from 0 to r, m2/s."""
    eta = max(1.0 - r / R, MIN_WALL_DISTANCE)
    if kind == POWER_LAW:
        p, top = parameter, 0.5 * (1.0 + parameter) * (2.0 + parameter) * U
        total = top / ((p + 1.0) * (p + 2.0)) - top * (eta ** (p + 1.0) / (p + 1.0) - eta ** (p + 2.0) / (p + 2.0))
        excess, integral = top * eta**p - U, total - 0.5 * U * (1.0 - eta) ** 2
    elif kind == LOG_LAW:
        defect, log = U * parameter, math.log(eta)
        excess, integral = (
            defect * (1.5 + log),
            -defect * (0.5 * eta - 0.5 * eta * eta + log * (eta - 0.5 * eta * eta)),
        )
    elif kind == PARABOLA:
        inside = min(1.0, r / R)
        square = inside * inside
        excess, integral = U * (1.0 - 2.0 * square), 0.5 * U * square * (1.0 - square)
    else:
        return 0.0, 0.0
    return excess, integral * R * R / r if r > 0.0 else 0.0


@compiled
def _flow_in_bend(p: Vector, f: FloatArray, o: int) -> tuple[Vector, Rotation]:
    U, R, bend, eta = f[o + SPEED], f[o + RADIUS], f[o + CURVE], p[1]
    x, z = p[0], bend - p[2]
    far, turn = math.hypot(x, z), math.atan2(x, z)
    # Within the bore: a point in the wall has the flow at the wall.
    r = math.hypot(bend - far, eta)
    inside = min(1.0, R / r) if r > 0.0 else 1.0
    xi, eta = inside * (bend - far), inside * eta
    far = bend - xi
    w, w1, w2 = f[o + STRENGTH], 0.0, 0.0
    for end in range(2):
        length = f[o + (START if end == 0 else FINISH) + LONG]
        if length > 0.0:
            sign, along = (1.0, turn) if end == 0 else (-1.0, f[o + ANGLE] - turn)
            v, v1, v2 = rise(along / length)
            w, w1, w2 = w - f[o + STRENGTH] * (1.0 - v), w1 + sign * v1 / length, w2 + v2 / (length * length)
    w1, w2 = f[o + STRENGTH] * w1, f[o + STRENGTH] * w2
    D, D1 = vortex_excess(xi, bend, R, U)
    u, across, up = U + w * D, 0.0, 0.0
    # Components along the axis, outward from the bend's centre, and along y; then their derivatives in these directions.
    u_s, u_r, u_y = w1 * D / far, -w * D1, 0.0
    r_s, r_r, r_y, y_s, y_r, y_y = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if w1 != 0.0 or w2 != 0.0:
        (phi1, phi2), (phi11, phi12) = crossing_potential(xi, eta, bend, R, U)
        g, g1 = w1 / far, w2 / (far * far)
        across, up = g * phi1, -g * phi2
        r_s, y_s = g1 * phi1, -g1 * phi2
        r_r, r_y = -g * phi11 - across / far, g * phi12
        y_r, y_y = g * phi12 - up / far, -g * (D - phi11)
    if f[o + SWIRL] != 0.0:
        share = turn / f[o + ANGLE]
        if f[o + SWIRL] > 0.0:
            A, A1, _ = rise(share)
        else:
            A, A1, _ = rise(2.0 * min(share, 1.0 - share))
            A1 = 2.0 * A1 if share < 0.5 else -2.0 * A1
        # As wide as the bend is there, the flow across it would not be free of divergence without this factor.
        narrow = U * abs(f[o + SWIRL]) * bend / far
        A, A1 = narrow * A, narrow * A1 / (far * f[o + ANGLE])
        (out, beside), (xx, xe, ex, ee) = dean_cells(xi, eta, R)
        across, up = across - A * out, up + A * beside
        r_s, y_s = r_s - A1 * out, y_s + A1 * beside
        r_r, r_y = r_r + A * xx + A * out / far, r_y - A * xe
        y_r, y_y = y_r - A * ex - A * beside / far, y_y + A * ee
    r_s -= u / far
    u_s += across / far
    cosine, sine = z / math.hypot(x, z), x / math.hypot(x, z)
    return (
        (u * cosine + across * sine, up, u * sine - across * cosine),
        _from_cylinder((u_s, u_r, u_y), (r_s, r_r, r_y), (y_s, y_r, y_y), cosine, sine),
    )


@compiled
def _from_cylinder(along: Vector, outward: Vector, level: Vector, c: float, s: float) -> Rotation:
    """Return a gradient in x, y, z of the local frame of a bend, from one in the directions along, outward and y."""
    # First the directions of the derivatives, then the components.
    a_x, a_z = _to_plane(along[0], along[1], c, s)
    o_x, o_z = _to_plane(outward[0], outward[1], c, s)
    l_x, l_z = _to_plane(level[0], level[1], c, s)
    xx, zx = _to_plane(a_x, o_x, c, s)
    xy, zy = _to_plane(along[2], outward[2], c, s)
    xz, zz = _to_plane(a_z, o_z, c, s)
    return (xx, xy, xz), (l_x, level[2], l_z), (zx, zy, zz)


@compiled
def _to_plane(along: float, outward: float, c: float, s: float) -> tuple[float, float]:
    """Return the components along x and z of one along the axis of a bend and one outward."""
    return along * c + outward * s, along * s - outward * c


@compiled
def _flow_in_reducer(p: Vector, f: FloatArray, o: int) -> tuple[Vector, Rotation]:
    R, narrow, length, arc = f[o + RADIUS], f[o + END_RADIUS], f[o + LENGTH], f[o + CURVE]
    sign = 1.0 if narrow > R else -1.0
    x = min(max(p[0], 0.0), length)
    early = x < 0.5 * length
    a = x if early else length - x
    root = math.sqrt(arc * arc - a * a)
    here = R + sign * (arc - root) if early else narrow - sign * (arc - root)
    slope, curl = sign * a / (root * here), sign * arc * arc / (root * root * root * here)
    if not early:
        curl = -curl
    u = f[o + SPEED] * (R / here) ** 2
    stretch, bent = u * slope, u * (curl - 3.0 * slope * slope)
    return (
        (u, stretch * p[1], stretch * p[2]),
        ((-2.0 * stretch, 0.0, 0.0), (bent * p[1], stretch, 0.0), (bent * p[2], 0.0, stretch)),
    )


@compiled
def bore_radius(point: Vector, f: FloatArray) -> float:
    """Return the radius of the bore around a point, m; from the run of a tee to its branch it changes gradually."""
    o, gap = find_part(point, f)
    p, kind = to_part(point, f, o), f[o + KIND]
    if kind == TEE:
        a, _, _ = beyond_bores(p, f, o)
        return float(f[o + RADIUS] + (f[o + END_RADIUS] - f[o + RADIUS]) * rise(a / f[o + END_RADIUS])[0])
    if kind == REDUCER:
        return gap + math.hypot(p[1], p[2])
    return float(f[o + RADIUS])


@compiled
def bore_at(point: Vector, f: FloatArray) -> Bore:
    """Return what surrounds a gust; the friction velocity changes within a part as the mean speed does."""
    gap, normal, o = fitting_gap(point, f)
    radius = bore_radius(point, f)
    narrowing = f[o + RADIUS] / radius if f[o + KIND] == REDUCER else 1.0
    return normal, radius, max(radius - gap, 0.0), f[o + FRICTION] * narrowing * narrowing
