"""Materials to print hulls of, by name, such as ``PETG``."""

import tomllib
from dataclasses import dataclass
from importlib.resources import files

_SAME = 0.004
"""Share by which the density of a material may differ: ASA and ABS, PETG and PLA differ by 2 %."""


@dataclass(frozen=True)
class Material:
    """A material as it is printed, at 23 degrees C; ``materials.toml`` defines each number.

    Its density is in kg/m3, by its ``source``; by ``mechanics``, Young's modulus, tensile strength along and ``across`` the layers
    in minutes, Pa, the share of these that is left after 1000 h under load, Poisson's ratio, the coefficient of linear thermal
    expansion, 1/K, and the mass of water that it takes up, over its own. The note says what to know of it in water, if anything.
    """

    density: float
    modulus: float
    strength: float
    across: float
    creep: float
    poisson: float
    expansion: float
    absorption: float
    source: str
    mechanics: str
    note: str


MATERIALS = {
    name: Material(**table)
    for name, table in tomllib.loads(files(__package__).joinpath("materials.toml").read_text("utf-8")).items()
}
"""Materials by name."""


def find_material(density: float) -> str | None:
    """Return the name of the material that has a density (kg/m3), or ``None``."""
    return next((name for name, m in MATERIALS.items() if abs(density - m.density) <= _SAME * m.density), None)


def find_expansion(density: float) -> float:
    """Return the coefficient of linear thermal expansion (1/K) of the material that has a density (kg/m3), or else of ABS."""
    return MATERIALS[find_material(density) or "ABS"].expansion
