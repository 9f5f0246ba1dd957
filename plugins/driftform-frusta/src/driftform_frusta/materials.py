"""Materials to print hulls of, by name, such as ``PETG``."""

import tomllib
from dataclasses import dataclass
from importlib.resources import files

_SAME = 0.004
"""Share by which the density of a material may differ: ASA and ABS, PETG and PLA differ by 2 %."""


@dataclass(frozen=True)
class Material:
    """A material: its density (kg/m3), the source of that, and what to know of it in water, if anything.

    Water uptake of resins: "Water Absorption of Underwater Products by Additive Manufacturing", Materials 17, 5953 (2024).
    """

    density: float
    source: str
    note: str


MATERIALS = {
    name: Material(**table)
    for name, table in tomllib.loads(files(__package__).joinpath("materials.toml").read_text("utf-8")).items()
}
"""Materials by name."""


def find_material(density: float) -> str | None:
    """Return the name of the material that has a density (kg/m3), or ``None``."""
    return next((name for name, m in MATERIALS.items() if abs(density - m.density) <= _SAME * m.density), None)
