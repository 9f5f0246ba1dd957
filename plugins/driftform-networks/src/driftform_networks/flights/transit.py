"""How long bodies that turbulence mixes take through a straight bore: faster than the water, and spread by its eddies."""

from functools import cache

import numpy as np

from driftform.water import Scenario

KARMAN, CORE = 0.4, 1 / 6
"""Von Karman's constant, and the bound of y (1 - y / R) in the eddy diffusivity, relative to R, as in the gusts of flights."""

FIT = 10.0
"""Factor of (a / R)^3 by which spheres spread more than these formulas say: fitted to flights of spheres of 0.1 to 0.6 of the bore."""


@cache
def section_means(size: float) -> tuple[float, float, float, float]:
    """Return what the centre of a neutral sphere meets that is anywhere in the section which it can reach.

    In the logarithmic law, averaged over the sphere, (U - U_mean) / u* = (3/2 + ln(1 - sqrt(r^2 + 2/5 a^2) / R)) / kappa. Bodies
    that move between its speeds by the diffusivity D(r) spread along the pipe as by the diffusivity
    2 / b^2 int [int_0^r (U - V) r' dr']^2 / (r D) dr, with b = R - a (Taylor, Proc. R. Soc. A 223, 1954). D is that of the gusts of
    flights, kappa u* min(y (1 - y / R), R / 6) at y = max(R - r, a), which fades at the wall with (1 - q^2)^2,
    q = a r / (b (R - r)).

    Args:
        size: radius a of the sphere over that of the bore, R, 0.001 to 0.95.

    Returns:
        V - U_mean over u*, 1; the variance of U over u*^2, 1; the diffusivity along the pipe by the profile, and that of the eddies
        themselves, both over u* R, 1.
    """
    r = np.linspace(0.0, 1 - size, 2001)[1:-1]
    weight = r / r.sum()
    excess = (1.5 + np.log(np.maximum(1 - np.sqrt(r**2 + 0.4 * size**2), 1e-3))) / KARMAN
    mean = float(weight @ excess)
    y = np.minimum(np.maximum(1 - r, size), 0.5)
    eddies = KARMAN * np.minimum(y * (1 - y), CORE)
    across = eddies * (1 - (size * r / ((1 - size) * (1 - r))) ** 2) ** 2
    flux = np.cumsum((excess - mean) * weight)
    along = 0.5 * (1 - size) ** 2 * r[0] * float((flux**2 / (r * across)).sum())
    return mean, float(weight @ (excess - mean) ** 2), along, float(weight @ eddies)


def transit(scenario: Scenario, width: float, length: float) -> tuple[float, float]:
    """Return mean and variance of the times that mixed bodies take through a pipe, relative to the time of the water.

    With the diffusivity K and its memory T = K / var U, the places of bodies have the variance 2 K (t - T (1 - exp(-t / T))) after the
    time t (Taylor, Proc. Lond. Math. Soc. 20, 1922), and their times that over V^2. A body as long as the eddies are wide is moved by
    the mean of two, which halves K across the pipe. All is increased by 1 + 10 (a / R)^3 (:data:`FIT`).

    Args:
        scenario: a straight pipe; one whose profile is not the logarithmic law carries bodies like the water.
        width: diameter of the body, m.
        length: of the pipe, m.
    """
    radius, speed, gusts = scenario.pipe.layout.inlet.radius, scenario.flow.speed, scenario.gusts
    if not hasattr(scenario.flow, "roughness") or not length:
        return 1.0, 0.0
    friction = scenario.friction_velocity() / speed
    size = float(np.clip(round(width / 2 / radius, 3), 1e-3, 0.95))
    mean, variance, along, eddies = section_means(size)
    eddy = gusts.memory * KARMAN * CORE * radius / max(gusts.strength, 1e-6)
    kept = (1 + np.exp(-width / np.sqrt(3) * gusts.crossing / eddy)) / 2
    pace, time = 1 + friction * mean, length / radius / (1 + friction * mean)
    memory = along / kept / (variance * friction)
    by_profile = along / kept * (time + memory * np.expm1(-time / memory))
    spread = 2 * friction * (by_profile + kept * eddies * time) * (1 + FIT * size**3)
    return 1 / pace, float(spread / pace**2 * (radius / length) ** 2)
