"""Cores and ballast to buy: balls of common materials and diameters, and ballast that is weighed out or cast to any mass."""

import math
from typing import Literal

from driftform.interfaces import Table, option
from driftform.types import Core
from driftform_frusta.kit_options import LEAD

CUSTOM = "custom"
"""Name of a core whose radius and mass are given."""

DENSITIES = {"steel": 7830.0, "stainless": 8000.0, "brass": 8530.0, "tungsten-carbide": 14_950.0, "glass": 2500.0}
"""Densities of balls, kg/m3.

``steel``: bearing balls of AISI 52100 (100Cr6); data sheets state 0.283 lb/in3, and makers count 30.5 balls of 20 mm to
the kilogram, 7827 kg/m3. Other sheets state 7810 to 7850. ``stainless``: AISI 316 (1.4401), 8.0 g/cm3. ``brass``: C26000
(CuZn30), 8.53 g/cm3 at 20 degrees C (ASTM B36). ``tungsten-carbide``: 94 % WC of 15 630 kg/m3 and 6 % cobalt of
8900 kg/m3 by mass, by the rule of mixtures. ``glass``: soda lime, EN 572-1 at 18 degrees C.
"""

DIAMETERS_MM = (10, 12, 15, 16, 20, 25, 30)
"""Diameters that ball makers keep in stock, mm."""


def make_ball(density: float, diameter: float) -> Core:
    """Return a homogeneous ball: ``density`` in kg/m3, ``diameter`` in m."""
    return Core(diameter / 2, density * math.pi / 6 * diameter**3)


CORES = {
    f"{material}-{diameter}mm": make_ball(density, diameter / 1000)
    for material, density in DENSITIES.items()
    for diameter in DIAMETERS_MM
}
"""Cores by name, such as ``steel-20mm``."""


def name_core(core: Core) -> str:
    """Return the name of a core, ``custom`` if it has none."""
    return next((name for name, known in CORES.items() if known == core), CUSTOM)


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
