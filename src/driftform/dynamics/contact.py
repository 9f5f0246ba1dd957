"""Contact of a body of revolution with the inside of a pipe: a frictionless, inelastic penalty on its rims."""

import numpy as np

from driftform.dynamics.compiled import compiled
from driftform.types import FloatArray

ONSET = 1e-3
"""Depth, m, over which the damper sets in, so that the force is continuous."""

NEAR = 0.1
"""Gap, relative to its radius, above which a rim cannot turn out to touch in the second round.

The first round errs by less than (r / R)^2 / 2 of the rim's radius r, R being that of the bore.
"""

BLUNT = 1e-3
"""Sine of the angle between axis and wall normal below which a rim touches with less than its radius.

A rim that faces the wall flatly touches all around at once; its lowest point is then undefined, and the force
passes through its centre.
"""


@compiled
def wall_gap(point: FloatArray, pipe: FloatArray, normal: FloatArray) -> float:
    """Return how far ``point`` is inside the pipe (m, negative outside) and fill the unit vector to the wall.

    The pipe is the union of its segments' bores; the first and the last run on beyond their outer ends. Where
    the point lies on an axis, ``normal`` is zero.
    """
    best = -np.inf
    count = pipe.shape[0]
    for s in range(count):
        ax, ay, az = pipe[s, 3] - pipe[s, 0], pipe[s, 4] - pipe[s, 1], pipe[s, 5] - pipe[s, 2]
        px, py, pz = point[0] - pipe[s, 0], point[1] - pipe[s, 1], point[2] - pipe[s, 2]
        along = (ax * px + ay * py + az * pz) / (ax * ax + ay * ay + az * az)
        if s > 0 and along < 0.0:
            along = 0.0
        if s < count - 1 and along > 1.0:
            along = 1.0
        px -= along * ax
        py -= along * ay
        pz -= along * az
        distance = np.sqrt(px * px + py * py + pz * pz)
        if pipe[s, 6] - distance > best:
            best = pipe[s, 6] - distance
            inverse = 1.0 / distance if distance > 0.0 else 0.0
            normal[0] = px * inverse
            normal[1] = py * inverse
            normal[2] = pz * inverse
    return best


@compiled
def rim_point(
    position: FloatArray, R: FloatArray, x: float, r: float, normal: FloatArray, point: FloatArray
) -> None:
    """Fill ``point`` with the point of the rim (x, r) that lies farthest along ``normal``, world frame, m."""
    along = R[0, 0] * normal[0] + R[1, 0] * normal[1] + R[2, 0] * normal[2]
    square = 0.0
    for i in range(3):
        d = normal[i] - along * R[i, 0]
        square += d * d
    scale = r / np.sqrt(square + BLUNT * BLUNT)
    for i in range(3):
        point[i] = position[i] + R[i, 0] * x + scale * (normal[i] - along * R[i, 0])


@compiled
def add_wall_forces(
    position: FloatArray,
    R: FloatArray,
    velocity: FloatArray,
    omega: FloatArray,
    rims: FloatArray,
    pipe: FloatArray,
    tau: FloatArray,
) -> None:
    """Add force (N) and torque (N m) of the wall about the body's origin, in the body frame, to ``tau`` (6,).

    ``position`` (m) and ``velocity`` (m/s) of the body's origin are in the world frame, ``omega`` (rad/s) in the
    body frame. A rim whose farthest point is the depth d beyond the wall presses with its share of k d + c d'
    onset(d), and never pulls. The share of a rim is s^2 / sqrt(sum of s^4 over all rims), with s^2 = k d^2: the
    springs then have the potential sqrt(sum of s^4) / 2, and a finely divided dome, of which many rims touch at
    once, is not many times stiffer than a single rim.
    """
    if pipe.shape[0] == 0:
        return
    reach = 0.0
    for k in range(rims.shape[0]):
        reach = max(reach, rims[k, 0] ** 2 + rims[k, 1] ** 2)
    normal = np.empty(3)
    if wall_gap(position, pipe, normal) > np.sqrt(reach):
        return
    centre = np.empty(3)
    points = np.empty((rims.shape[0], 3))
    normals = np.empty((rims.shape[0], 3))
    depths = np.empty(rims.shape[0])
    total = 0.0
    for k in range(rims.shape[0]):
        depths[k] = 0.0
        for i in range(3):
            centre[i] = position[i] + R[i, 0] * rims[k, 0]
        gap = wall_gap(centre, pipe, normals[k])
        if gap > rims[k, 1]:
            continue
        # The farthest point defines the normal and the normal the point; the bore is wide, so two rounds settle.
        rim_point(position, R, rims[k, 0], rims[k, 1], normals[k], points[k])
        gap = wall_gap(points[k], pipe, normals[k])
        if gap > NEAR * rims[k, 1]:
            continue
        rim_point(position, R, rims[k, 0], rims[k, 1], normals[k], points[k])
        depths[k] = max(0.0, -wall_gap(points[k], pipe, normals[k]))
        total += (rims[k, 2] * depths[k] ** 2) ** 2
    if total == 0.0:
        return
    arm = np.empty(3)
    push = np.empty(3)
    for k in range(rims.shape[0]):
        depth = depths[k]
        if depth == 0.0:
            continue
        for i in range(3):
            arm[i] = 0.0
            push[i] = 0.0
            for j in range(3):
                arm[i] += R[j, i] * (points[k, j] - position[j])
                push[i] -= R[j, i] * normals[k, j]
        sx = omega[1] * arm[2] - omega[2] * arm[1]
        sy = omega[2] * arm[0] - omega[0] * arm[2]
        sz = omega[0] * arm[1] - omega[1] * arm[0]
        speed = -(push[0] * sx + push[1] * sy + push[2] * sz)
        for i in range(3):
            speed += velocity[i] * normals[k, i]
        share = rims[k, 2] * depth**2 / np.sqrt(total)
        force = share * (rims[k, 2] * depth + rims[k, 3] * speed * min(1.0, depth / ONSET))
        if force <= 0.0:
            continue
        for i in range(3):
            tau[i] += force * push[i]
        tau[3] += force * (arm[1] * push[2] - arm[2] * push[1])
        tau[4] += force * (arm[2] * push[0] - arm[0] * push[2])
        tau[5] += force * (arm[0] * push[1] - arm[1] * push[0])
