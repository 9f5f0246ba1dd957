"""Cores to buy: balls of common materials and diameters, by name, such as ``steel-20mm``."""

import math

from driftform.types import Core

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
"""Cores by name."""


def name_core(core: Core) -> str:
    """Return the name of a core, ``custom`` if it has none."""
    return next((name for name, known in CORES.items() if known == core), CUSTOM)
