"""Steps of a rigid body in water as the programs take them that read our files.

All of them take steps of first order, in which velocities change first, that of the centre of gravity in the world frame,
and the pose changes by the new velocities; these are the steps of DART. Programs that multiply added mass by an
acceleration use that of the previous step, smoothed or not.
"""

import math

from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.rotations import rotation_from_vector
from driftform.util.small_vectors import (
    ZERO,
    Rotation,
    Vector,
    add,
    cross,
    multiply,
    scale,
    subtract,
    to_body,
    to_world,
)


@compiled
def fill_path(
    step: float,
    every: int,
    R: Rotation,
    v: Vector,
    inverse: FloatArray,
    linear: FloatArray,
    products: FloatArray,
    ellipsoids: FloatArray,
    lagged: FloatArray,
    lacking: FloatArray,
    net: tuple[float, float, float, float],
    cob: Vector,
    current: Vector,
    out: FloatArray,
    path: FloatArray,
) -> None:
    """Fill in the displacement of the centre of gravity relative to the water.

    Args:
        step, every: time step, s; steps between two points of the path.
        R, v: attitude, body to world, and velocity (body axes, m/s) at the release.
        inverse: of the mass matrix by which the program divides, (6, 6).
        linear, products, ellipsoids: see :class:`driftform_robotics.models.gap.Reader`.
        lagged: added mass that the program multiplies by the acceleration of the previous step, (6, 6).
        lacking: added mass whose force -M_A (w x u) the program lacks in the current u on a body that rotates at w.
        net: weight less buoyancy, and buoyancy, N; weight of the newest acceleration; density, kg/m3.
        cob, current: centre of buoyancy (m, body axes); u (m/s, world frame).
        out: work space, (6,).
        path: to be filled in, m, (n, 3).
    """
    w, place, before = ZERO, ZERO, (ZERO, ZERO)
    for n in range(path.shape[0] * every):
        rates = (v[0], v[1], v[2], w[0], w[1], w[2])
        for i in range(6):
            out[i] = 0.0
            for j in range(6):
                for k in range(6):
                    out[i] += (products[0, i, j, k] * abs(rates[k]) + products[1, i, j, k] * rates[k]) * rates[j]
        for row in range(ellipsoids.shape[0]):
            add_ellipsoid(ellipsoids[row], rates, net[3], out)
        slow, lag = multiply(linear, v, w), multiply(lagged, before[0], before[1])
        turned = multiply(lacking, cross(w, to_body(R, current)), ZERO)
        force = subtract(add((out[0], out[1], out[2]), turned[0]), add(add(slow[0], lag[0]), scale(net[0], R[2])))
        moment = subtract(add((out[3], out[4], out[5]), turned[1]), add(slow[1], lag[1]))
        a, alpha = multiply(inverse, force, add(moment, cross(cob, scale(net[1], R[2]))))
        before = (
            add(before[0], scale(net[2], subtract(a, before[0]))),
            add(before[1], scale(net[2], subtract(alpha, before[1]))),
        )
        moving = to_world(R, add(v, scale(step, add(a, cross(w, v)))))
        w, place = add(w, scale(step, alpha)), add(place, scale(step, moving))
        turn = rotation_from_vector(step * w[0], step * w[1], step * w[2])
        R = (to_body(turn, R[0]), to_body(turn, R[1]), to_body(turn, R[2]))
        v = to_body(R, moving)
        if (n + 1) % every == 0:
            path[n // every, 0], path[n // every, 1], path[n // every, 2] = place


@compiled
def add_ellipsoid(row: FloatArray, nu: tuple[float, ...], density: float, out: FloatArray) -> None:
    """Add force and moment about the centre of gravity by MuJoCo's ellipsoid model without slender drag, (6,).

    ``row`` is one of :func:`driftform_robotics.models.ellipsoid.fit_ellipsoids`, ``nu`` the velocities (body axes, (6,)).
    The law is that of ``mj_viscousForces`` in MuJoCo's ``src/engine/engine_passive.c``.
    """
    a, b, x = row[0], row[1], row[2]
    u, v, w, p, q, r = nu[0], nu[1] + x * nu[5], nu[2] - x * nu[4], nu[3], nu[4], nu[5]
    speed, side = math.sqrt(u * u + v * v + w * w), v * v + w * w
    ends, flank = b**4, (a * b) ** 2
    projected = ends * u * u + flank * side
    squared = ends * ends * u * u + flank * flank * side
    area = math.pi * math.sqrt(squared / projected) if projected > 0.0 else 0.0
    drag = -density * row[3] * area * speed
    widest = max(a, b) ** 4
    moments = (
        8.0 / 15.0 * math.pi * a * ends * p,
        8.0 / 15.0 * math.pi * b * widest * q,
        8.0 / 15.0 * math.pi * b * widest * r,
    )
    turn = -density * row[4] * math.sqrt(moments[0] ** 2 + moments[1] ** 2 + moments[2] ** 2)
    # Kutta's lift (n x v) x v = v (n v) - n v^2, with n along the normal of the projected area.
    lift = density * row[5] * area * projected / (speed * squared) if squared > 0.0 else 0.0
    spin = density * row[6] * 4.0 / 3.0 * math.pi * a * b * b
    fx = drag * u + lift * (u * projected - ends * u * speed * speed) + spin * (q * w - r * v)
    fy = drag * v + lift * (v * projected - flank * v * speed * speed) + spin * (r * u - p * w)
    fz = drag * w + lift * (w * projected - flank * w * speed * speed) + spin * (p * v - q * u)
    out[0], out[1], out[2] = out[0] + fx, out[1] + fy, out[2] + fz
    out[3], out[4], out[5] = out[3] + turn * p, out[4] + turn * q - x * fz, out[5] + turn * r + x * fy
