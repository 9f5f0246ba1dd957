"""Buoyancy of a body that may extend through the surface of the water, slice by slice.

A slice of radius r and width w, whose axis makes the angle asin(e) with the horizontal, is a disc whose heights
above and below its centre follow the semicircle law within +-a, a^2 = r^2 (1 - e^2) + w^2 e^2 / 3: exactly for a
thin disc, and with the right variance for an upright cylinder. With the depth d of its centre and
xi = d / a the share under water is F(xi) = (xi sqrt(1 - xi^2) + asin xi) / pi + 1/2, and its potential energy
rho g V a (xi F + 2/(3 pi) (1 - xi^2)^(3/2)). Force and moment are the derivatives of that energy, so that a body
that bobs without damping keeps its energy.
"""

import math

from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import Rotation, Vector, Wrench, cross, dot, scale


@compiled
def submerged_share(depth: float, half_height: float) -> float:
    """Return F, the share of a slice that is under water, its centre at ``depth``; both arguments in m.

    >>> submerged_share(0.0, 0.01), submerged_share(-0.01, 0.01), submerged_share(0.02, 0.01)
    (0.5, 0.0, 1.0)
    """
    if depth >= half_height:
        return 1.0
    if depth <= -half_height:
        return 0.0
    xi = depth / half_height
    return (xi * math.sqrt(1.0 - xi * xi) + math.asin(xi)) / math.pi + 0.5


@compiled
def energy_slope(depth: float, half_height: float) -> float:
    """Return 2/(3 pi) (1 - xi^2)^(3/2), the derivative of a slice's potential energy with respect to a, over rho g V."""
    xi = depth / half_height
    if xi * xi >= 1.0:
        return 0.0
    return float(2.0 / (3.0 * math.pi) * (1.0 - xi * xi) ** 1.5)


@compiled
def half_height(radius: float, width: float, e: float) -> float:
    """Return a, m; ``e`` is the vertical component of the axis."""
    # The last term gives a thin upright disc a height that is not zero.
    return math.sqrt(radius * radius * (1.0 - e * e) + width * width * e * e / 3.0 + 1e-18)


@compiled
def slice_depth(height: float, R: Rotation, x: float, centre: Vector, level: float) -> float:
    """Return the depth (m) of the middle of the slice at ``x`` below the surface; negative above it.

    ``height`` of the body's origin and ``level`` of the surface are in the world frame; ``centre`` is the centre of
    buoyancy in the body frame, whose y and z are those of every slice's middle.
    """
    return level - height - dot(R[2], (x, centre[1], centre[2]))


@compiled
def buoyancy(
    height: float, R: Rotation, centre: Vector, level: float, weight: float, slices: FloatArray
) -> tuple[Wrench, float, float]:
    """Return the buoyancy of slices about the body's origin, the volume under water (m3), and the x of its centre (m).

    Args:
        height, centre, level: see :func:`slice_depth`.
        weight: of a cubic metre of water, N/m3.
        slices: x, radius (m), volume (m3), width (m), (n, 4).
    """
    volume = moment = turning = 0.0
    for k in range(slices.shape[0]):
        x, r, w = slices[k, 0], slices[k, 1], slices[k, 3]
        a = half_height(r, w, R[2][0])
        depth = slice_depth(height, R, x, centre, level)
        share = submerged_share(depth, a) * slices[k, 2]
        volume += share
        moment += share * x
        # The energy depends on e, which gives a moment on the axis: -dU/de (x cross up).
        turning += slices[k, 2] * energy_slope(depth, a) * R[2][0] * (w * w / 3.0 - r * r) / a
    x = moment / volume if volume > 0.0 else 0.0
    force = scale(weight * volume, R[2])
    torque = cross((x, centre[1], centre[2]), force)
    turning *= weight
    return ((force, (torque[0], torque[1] + turning * R[2][2], torque[2] - turning * R[2][1])), volume, x)


@compiled
def buoyant_energy(
    height: float, R: Rotation, centre: Vector, level: float, weight: float, slices: FloatArray
) -> float:
    """Return the potential energy of the slices' buoyancy, J; zero for a body far above the surface."""
    energy = 0.0
    for k in range(slices.shape[0]):
        a = half_height(slices[k, 1], slices[k, 3], R[2][0])
        depth = slice_depth(height, R, slices[k, 0], centre, level)
        energy += weight * slices[k, 2] * (depth * submerged_share(depth, a) + a * energy_slope(depth, a))
    return energy
