"""Ideal flow in and near a bend: the free vortex, and the flow across the bore where plug flow changes into it.

In a bend of radius R_c and bore a the velocity is K / r about the bend's axis. With q = (R_c - sqrt(R_c^2 - a^2)) / a, the mean speed U
over the bore gives K = U a / (2 q). Where the axial velocity changes from U to U + w D along the pipe, with D = K / r - U, continuity asks
for a flow -w' grad(phi) across it, with the potential phi of the disc::

    laplacian(phi) = D        d(phi)/dn = 0 on the wall

Its closed form: with xi towards the bend's centre, eta across, zeta = (xi + i eta) / a and F = ln(1 - q zeta)::

    phi_xi - i phi_eta = -K ln(R_c - xi) + K L - U xi + W
    W = K F + K (F + q zeta) / zeta^2 + U a zeta / 2        L = ln((R_c + sqrt(R_c^2 - a^2)) / 2)

The secondary flow is a pair of cells, outward across the middle of the bore and back along its sides (Dean). Ideal flow turns the
vorticity of a profile u(eta) by twice the angle theta of the bend (Squire and Winter, J. Aeronaut. Sci. 18, 1951, 271)::

    laplacian(psi) = 2 theta du/d(eta)        psi = 0 on the wall

For a parabola psi is theta U eta (rho^2 - 1), with rho the distance from the axis over the bore's radius; for any profile
the speed on the axis is theta times the excess of the profile there. The cells have this shape, and the strength is an input.
"""

import math
from typing import TypeAlias

from driftform.util.compiled import compiled

Plane: TypeAlias = tuple[float, float]
"""Components along xi and eta."""

FEW = 0.1
"""|q zeta| below which W is summed as a power series: its closed form is a small difference of large numbers there."""

TERMS = 14


DECAY = 10.0
"""Length, in radii of the bore, of the decay of the secondary flow after a bend: a tenth is left after 15 diameters.

After a sharp bend the flow recovers within 10 to 30 diameters at a Reynolds number of 1e4 (Appl. Sci. 14, 2024, 7895).
"""


@compiled
def dean_cells(xi: float, eta: float, a: float) -> tuple[Plane, tuple[float, float, float, float]]:
    """Return the secondary flow of speed 1 on the axis, and its derivatives: of xi by xi and eta, of eta by xi and eta."""
    x, y = xi / a, eta / a
    return ((x * x + 3.0 * y * y - 1.0, -2.0 * x * y), (2.0 * x / a, 6.0 * y / a, -2.0 * y / a, -2.0 * x / a))


@compiled
def vortex_strength(bend: float, a: float, speed: float) -> tuple[float, float]:
    """Return K (m2/s) and q of a bend of radius ``bend`` with the bore ``a``, m, at the mean ``speed``, m/s."""
    q = (bend - math.sqrt(bend * bend - a * a)) / a
    return 0.5 * speed * a / q, q


@compiled
def vortex_excess(xi: float, bend: float, a: float, speed: float) -> Plane:
    """Return D = K / (R_c - xi) - U (m/s) and its derivative with respect to xi, 1/s."""
    K, _ = vortex_strength(bend, a, speed)
    far = bend - xi
    return K / far - speed, K / (far * far)


@compiled
def crossing_potential(xi: float, eta: float, bend: float, a: float, speed: float) -> tuple[Plane, Plane]:
    """Return the gradient of phi (m2/s), and its derivatives phi_xixi and phi_xieta, m/s; phi_etaeta is D - phi_xixi."""
    K, q = vortex_strength(bend, a, speed)
    zeta = complex(xi, eta) / a
    small = q * zeta
    one, two = complex(0.0, 0.0), complex(0.0, 0.0)
    if abs(small) < FEW:
        # ln(1 - u) = -(u + u^2/2 + ...); the sum without its first term, over zeta^2, and its derivative.
        power = complex(q * q, 0.0)
        for n in range(2, TERMS):
            one -= power / n
            two -= (n - 1) * power * q / (n + 1)
            power *= small
        F = zeta * zeta * one - small
    else:
        modulus = abs(1.0 - small)
        F = complex(math.log(modulus), math.atan2(-small.imag, 1.0 - small.real))
        one = (F + small) / (zeta * zeta)
        two = (-q * q / (1.0 - small) - 2.0 * one) / zeta
    W = K * F + K * one + 0.5 * speed * a * zeta
    slope = (-K * q / (1.0 - small) + K * two + 0.5 * speed * a) / a
    level = math.log(0.5 * (bend + math.sqrt(bend * bend - a * a)))
    along = K * (level - math.log(bend - xi)) - speed * xi + W.real
    return (along, -W.imag), (K / (bend - xi) - speed + slope.real, -slope.imag)
