"""Link -> the ellipsoid by which MuJoCo computes the forces of water on a body.

The forces are those of MuJoCo's documentation, "Computation: fluid forces, ellipsoid model", and of
``mj_ellipsoidFluidModel`` in ``src/engine/engine_passive.c``.
"""

from dataclasses import dataclass

import numpy as np

from driftform_robotics.models.link import Link

_MAX_SLENDERNESS = 1e4
"""Greatest ratio of length to diameter, and of diameter to length, of the ellipsoid."""


@dataclass(frozen=True)
class Ellipsoid:
    """A spheroid about the body's axis.

    Attributes:
        along, across: half axes, m.
        x: position of its centre along the axis, relative to the centre of gravity, m.
        blunt, slender, angular: MuJoCo's drag coefficients.
    """

    along: float
    across: float
    x: float
    blunt: float
    slender: float
    angular: float

    def added_inertia(self, density: float) -> float:
        """Return the added moment of inertia about a transverse axis through the centre, kg m2 (Lamb, section 115)."""
        a, b = self.along, self.across
        alpha, beta = _lamb_coefficients(b / a)
        S, D = a * a + b * b, a * a - b * b
        if abs(D) < 1e-9 * S:
            return 0.0
        displaced = density * 4 / 3 * np.pi * a * b * b
        return float(displaced / 5 * D * D * (beta - alpha) / (2 * D - S * (beta - alpha)))


def _lamb_coefficients(ratio: float) -> tuple[float, float]:
    """Return alpha_0 and beta_0 of a spheroid whose radius is ``ratio`` times its half length.

    Lamb, Hydrodynamics (6th ed.), section 114: alpha_0 = a b^2 int_0^inf dl / ((a^2 + l)^(3/2) (b^2 + l)), which is
    2/3 a b^2 R_D(b^2, b^2, a^2) by Carlson's integral (DLMF 19.16.5); the three sum to 2.
    """
    from scipy.special import elliprd

    s = ratio * ratio
    alpha = 2 / 3 * s * float(elliprd(s, s, 1.0))
    return alpha, (2 - alpha) / 2


def added_mass_factors(ratio: float) -> tuple[float, float]:
    """Return the ratios of added to displaced mass of a spheroid along and across its axis.

    ``ratio`` is its radius over its half length.

    >>> [round(k, 4) for k in added_mass_factors(0.5)]
    [0.21, 0.7042]
    """
    alpha, beta = _lamb_coefficients(ratio)
    return alpha / (2 - alpha), beta / (2 - beta)


def fit_ellipsoid(link: Link, density: float) -> Ellipsoid:
    """Return the spheroid that has the link's added mass along and across its axis, at the same centre.

    Its drag equals that of the link for motion along each axis alone, as far as positive coefficients allow.
    """
    from scipy.optimize import brentq

    along, across = float(link.added_mass[0, 0]), float(link.added_mass[1, 1])

    def excess(log_ratio: float) -> float:
        k1, k2 = added_mass_factors(float(np.exp(log_ratio)))
        return float(np.log(k1 / k2) - np.log(along / across))

    bound = float(np.log(_MAX_SLENDERNESS))
    ratio = float(np.exp(brentq(excess, -bound, bound, xtol=1e-12)))
    k1, _ = added_mass_factors(ratio)
    a = float(np.cbrt(along / k1 / (density * 4 / 3 * np.pi * ratio**2)))
    b = ratio * a
    return Ellipsoid(a, b, float(link.added_mass[1, 5]) / across, *_fit_drag(link, density, a, b))


def _fit_drag(link: Link, density: float, a: float, b: float) -> tuple[float, float, float]:
    """Return the blunt, slender and angular drag coefficients.

    For motion at the speed v along an axis with the projected area A, MuJoCo's force is
    rho (blunt A + slender (A_max - A)) v^2; for rotation across the axis its moment is
    rho angular 8/15 pi b max(a, b)^4 w^2.
    """
    ends, side = np.pi * b * b, np.pi * a * b
    surge, sway, pitch = (float(link.quadratic_damping[i, i]) / density for i in (0, 1, 4))
    seen, hidden, shown = (sway, surge, (side, ends)) if side >= ends else (surge, sway, (ends, side))
    blunt = seen / shown[0]
    spare = shown[0] - shown[1]
    slender = max(0.0, (hidden - blunt * shown[1]) / spare) if spare > 1e-9 * shown[0] else 0.0
    return blunt, slender, pitch / (8 / 15 * np.pi * b * max(a, b) ** 4)
