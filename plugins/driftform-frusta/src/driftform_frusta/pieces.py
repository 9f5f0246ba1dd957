"""Ballast to buy: balls in sizes that are sold, and what is weighed out or cast to any mass."""

from typing import Literal

from driftform.interfaces import Table, option
from driftform_frusta.cores import DENSITIES, DIAMETERS_MM, make_ball
from driftform_frusta.kit_options import LEAD

WEIGHED = {"tungsten-putty": 10_200.0, "lead": LEAD}
"""Densities of what can have any mass, kg/m3.

``tungsten-putty``: powder in epoxy, half of either by volume, by the rule of mixtures (19 250 and 1150 kg/m3). ``lead`` is
cast.
"""

SIZES_MM = (3, 4, 5, 6, *DIAMETERS_MM)
"""Diameters of balls of ballast, mm: whole millimetres of ISO 3290-1 that ball makers list with their number per kilogram."""


class BallastOptions(Table):
    """Pieces of ballast that a hull may hold beside its core."""

    material: Literal["steel", "stainless", "tungsten-carbide", "tungsten-putty", "lead"] = option(
        "steel",
        f"'steel', 'stainless' and 'tungsten-carbide' are balls of {', '.join(map(str, SIZES_MM))} mm; 'tungsten-putty' is "
        "weighed out, and 'lead' is cast, each as one ball of any mass",
    )
    most: float = option(0.1, "maximum mass of the ballast", "kg", ge=0, le=1e4)

    @property
    def density(self) -> float:
        """Density of the ballast, kg/m3."""
        return WEIGHED.get(self.material) or DENSITIES[self.material]

    @property
    def is_sold_in_sizes(self) -> bool:
        """Whether it comes as balls of some sizes, and not in any mass."""
        return self.material not in WEIGHED

    def list_radii(self) -> list[float]:
        """Return the radius of each ball that may be used, in ascending order, m."""
        balls = (make_ball(self.density, size / 1000) for size in SIZES_MM)
        return [ball.radius for ball in balls if ball.mass <= self.most]


def is_sold(diameter: float, density: float) -> bool:
    """Return whether a ball is one to buy, by its diameter (m) and its density (kg/m3)."""
    return density not in WEIGHED.values() and round(1000 * diameter, 3) in SIZES_MM
