"""The plume of a leak: concentration downstream of a point of the pipe's wall, in closed form.

A substance enters at the wall of a bore of radius R at the rate Q. The water carries it at the speed U and spreads it
across the bore with the turbulent diffusivity K. Diffusion along the axis is negligible against the current (U x / K is
several thousand), so x / U acts as time, and the concentration is that of an instantaneous line source in a disc with
an impermeable rim. With tau = K x / (U R^2), and r and phi the polar coordinates of the bore, phi from the leak:

    C / (Q / (U pi R^2)) = 1 + sum of e_m cos(m phi) J_m(k r / R) / J_m(k) / (1 - m^2 / k^2) exp(-k^2 tau)

over all m and the positive roots k of J_m'(k) = 0, with e_0 = 1 and e_m = 2: Green's function of the disc (Carslaw and
Jaeger, Conduction of Heat in Solids, second edition, 1959, chapter 14) with the source on its rim. It holds everywhere
downstream and conserves mass at every cross-section, but near the leak it needs too many terms. There the wall is almost
flat and reflects the plume: the concentration is twice that of the unbounded plume,
Q / (4 pi K x) exp(-U s^2 / (4 K x)) at the distance s across the flow, plus a few percent from the curvature of the
wall, which has a closed form to first order.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from driftform.types import FloatArray
from driftform.water import Scenario, Vector

KARMAN = 0.4
"""Von Karman's constant kappa."""

MAX_NEAR_TAU = 0.003
"""Largest tau for the formula near the leak; there it agrees with the series within 0.2 % of the peak."""

MAX_MODE_EXPONENT = 20.0
"""Terms of the series below exp(-20) are left out."""

MAX_PLUME_EXPONENT = 25.0
"""The concentration is 0 where the unbounded plume is below exp(-25) of its peak."""


@dataclass(frozen=True, eq=False)
class Plume:
    """The plume of a leak.

    Attributes:
        leak: point of the wall, world frame, m, (3,).
        axis: unit vector downstream, world frame, (3,).
        outward: unit vector across the bore, from its axis towards the leak, world frame, (3,).
        radius: radius of the bore, m.
        length: distance from the leak to the downstream end of the pipe, m.
        speed: mean speed of the water, m/s.
        diffusivity: turbulent diffusivity across the bore, m2/s.
        rate: mass flow that enters, kg/s.
    """

    leak: FloatArray
    axis: FloatArray
    outward: FloatArray
    radius: float
    length: float
    speed: float
    diffusivity: float
    rate: float

    def concentration(self, points: FloatArray) -> FloatArray:
        """Return the concentration at points of the world (n, 3), kg/m3, (n,): 0 upstream of the leak.

        A point in the wall has the concentration at the wall's surface.
        """
        centre = self.leak - self.radius * self.outward
        off = points - centre
        x = off @ self.axis
        y = off @ self.outward
        z = off @ np.cross(self.axis, self.outward)
        r, phi = np.minimum(np.hypot(y, z) / self.radius, 1.0), np.arctan2(z, y)
        tau = self.diffusivity * x / (self.speed * self.radius**2)
        # Relative to an even mixture, Q / (U A).
        return self.rate / (self.speed * np.pi * self.radius**2) * relative_concentration(tau, r, phi)


def relative_concentration(tau: FloatArray, r: FloatArray, phi: FloatArray) -> FloatArray:
    """Return the concentration relative to that of an even mixture, for a source on the rim of a unit disc, (n,).

    Args:
        tau: dimensionless time K x / (U R^2) since the release, (n,); 0 before it.
        r, phi: polar coordinates, r up to 1, phi (rad) from the source, (n,).
    """
    found = np.zeros(np.shape(tau))
    square = 1 + r * r - 2 * r * np.cos(phi)
    # The concentration at the source is infinite at tau = 0; its value shortly after is large enough.
    tau = np.where(tau > 0, np.maximum(tau, 1e-9), 0.0)
    reached = (tau > 0) & (square < 4 * MAX_PLUME_EXPONENT * tau)
    near, far = reached & (tau < MAX_NEAR_TAU), reached & (tau >= MAX_NEAR_TAU)
    found[near] = relative_concentration_near(tau[near], r[near], phi[near])
    found[far] = relative_concentration_far(tau[far], r[far], phi[far])
    return found


def relative_concentration_near(tau: FloatArray, r: FloatArray, phi: FloatArray) -> FloatArray:
    """Return the relative concentration near the source, to first order in the curvature of the wall.

    With the depth d = 1 - r below the wall and the arc phi, z = d / (2 sqrt(tau)) and eta = phi / sqrt(tau), twice the
    unbounded plume, exp(-s^2 / (4 tau)) / (2 pi tau), solves the equation to this order except for its slope at the
    curved wall. The following term corrects the slope and conserves the mass:

        sqrt(pi tau) / 2 (eta^2 i2erfc(z) + erfc(z) - 2 i2erfc(z)) exp(-eta^2 / 4) / (2 pi tau)

    with the iterated integral i2erfc of the complementary error function.
    """
    from scipy.special import erfc

    square = 1 + r * r - 2 * r * np.cos(phi)
    z, eta = (1 - r) / (2 * np.sqrt(tau)), phi / np.sqrt(tau)
    plane = np.exp(-square / (4 * tau))
    whole = erfc(z)
    twice = ((1 + 2 * z * z) * whole - 2 / np.sqrt(np.pi) * z * np.exp(-z * z)) / 4
    bent = np.exp(-eta * eta / 4) * np.sqrt(np.pi * tau) / 2 * (eta * eta * twice + whole - 2 * twice)
    # A disc of radius 1 has the area pi.
    return np.asarray((plane + bent) / (2 * tau), dtype=np.float64)


def relative_concentration_far(tau: FloatArray, r: FloatArray, phi: FloatArray) -> FloatArray:
    """Return the relative concentration by the series, without the terms that are negligible at each point."""
    from scipy.special import jv

    found = np.ones(np.shape(tau))
    if not len(tau):
        return found
    order, root, weight = _compute_modes(min(MAX_NEAR_TAU, float(tau.min())))
    # In order of decreasing tau: small values need the most terms.
    for i in np.argsort(-tau):
        count = int(np.searchsorted(root, np.sqrt(MAX_MODE_EXPONENT / tau[i])))
        m, k = order[:count], root[:count]
        terms = weight[:count] * np.exp(-k * k * tau[i]) * np.cos(m * phi[i]) * jv(m, k * r[i])
        found[i] += terms.sum()
    # Rounding may make a very small concentration negative.
    return np.maximum(found, 0.0)


@lru_cache(maxsize=4)
def _compute_modes(tau: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the orders m, the roots k of J_m'(k) = 0, and the factors e_m / (J_m(k) (1 - m^2 / k^2)).

    They include every mode that is not negligible at ``tau`` or later, in the order of the roots.
    """
    from scipy.special import jnp_zeros, jv

    largest = np.sqrt(MAX_MODE_EXPONENT / tau)
    # The first root of J_m' is larger than m, and two roots are about pi apart.
    found = [(n, jnp_zeros(n, int((largest - n) / np.pi) + 2)) for n in range(int(largest) + 1)]
    orders = np.concatenate([np.full(len(roots), float(n)) for n, roots in found])
    k = np.concatenate([roots for _, roots in found])
    m, k = orders[k < largest], k[k < largest]
    by_root = np.argsort(k)
    m, k = m[by_root], k[by_root]
    return m, k, np.where(m == 0, 1.0, 2.0) / (jv(m, k) * (1 - (m / k) ** 2))


def eddy_diffusivity(scenario: Scenario) -> float:
    """Return the turbulent diffusivity across a pipe, m2/s: kappa u* R / 6.

    By Reynolds' analogy the diffusivities of momentum and mass are equal: the shear stress u*^2 r / R divided by the
    slope u* / (kappa y) of the logarithmic law is kappa u* y (1 - y / R), and kappa u* R / 6 is its mean over the bore
    (as kappa u* d / 6 is the mean over the depth d of a channel: Elder, J. Fluid Mech. 5, 1959; Fischer et al., Mixing in Inland and Coastal Waters,
    1979, chapter 5). The friction velocity u* is that of the pipe's friction factor.
    """
    return KARMAN * scenario.friction_velocity() * scenario.pipe.layout.inlet.radius / 6


def make_plume(scenario: Scenario, point: Vector, rate: float, diffusivity: float | None = None) -> Plume:
    """Return the plume of a leak at the point of the wall that is nearest to ``point`` (world frame, m).

    For a point on the pipe's axis the leak is in the wall below it, or at its side if the pipe is vertical. The rate is in
    kg/s, the diffusivity in m2/s, by default :func:`eddy_diffusivity`.

    Raises ValueError if the scenario has no pipe or one that is not straight, or if its water is at rest.
    """
    segment = scenario.pipe.straight
    if segment is None:
        raise ValueError(
            "a leak needs a straight pipe, but the scenario is open water"
            if scenario.pipe.is_open
            else "a leak needs a straight pipe, but that of the scenario has other parts"
        )
    if scenario.flow.speed == 0:
        raise ValueError("the water is at rest: it carries no plume")
    start, way = np.array(segment.start), np.subtract(segment.end, segment.start)
    length = float(np.linalg.norm(way))
    axis = way / length
    along = float(axis @ (np.array(point) - start))
    outward = np.array(point) - start - along * axis
    if np.linalg.norm(outward) < 1e-9 * segment.radius:
        down = np.array([0.0, 0.0, -1.0])
        outward = down - (axis @ down) * axis
        if np.linalg.norm(outward) < 1e-9:
            outward = np.array([0.0, 1.0, 0.0]) - axis[1] * axis
    outward = outward / np.linalg.norm(outward)
    leak = start + along * axis + segment.radius * outward
    # With a negative speed the water carries the plume towards the inlet.
    downstream, left = (axis, length - along) if scenario.flow.speed > 0 else (-axis, along)
    spread, speed = (eddy_diffusivity(scenario) if diffusivity is None else diffusivity, abs(scenario.flow.speed))
    return Plume(leak, downstream, outward, segment.radius, left, speed, spread, rate)
