"""The gland of an O-ring between a plug and its bore, and the ring to buy for it."""

import math
import tomllib
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

_SECTIONS: list[dict[str, Any]] = tomllib.loads(files(__package__).joinpath("o-rings.toml").read_text("utf-8"))[
    "section"
]

STRETCH = 0.01, 0.05
"""Minimum and maximum stretch of an O-ring round its groove (Apple Rubber, Seal Design Guide, "Dimensional considerations")."""

NITRILE = 1250.0
"""Density of an O-ring, kg/m3: data sheets of nitrile of 70 Shore A have 1200 to 1300, by how much carbon black is in it."""

_NEAR = 0.02
"""mm: a cord that differs by less is that of the standard: 1.8 mm is 1.78 mm."""


@dataclass(frozen=True)
class Gland:
    """Room for an O-ring, mm: its ``cord``, the ``depth`` from the bottom of the groove to the bore, and the mean ``width``.

    One side of the groove slopes by 45 degrees, to be printed, so that its bottom is narrower.
    """

    cord: float
    depth: float
    width: float

    @property
    def bottom(self) -> float:
        """Width of the groove's bottom."""
        return self.width - self.depth / 2

    @property
    def proud(self) -> float:
        """How far the ring exceeds the bore before it is squeezed."""
        return self.cord - self.depth

    def fit_groove(self, widest: float) -> float:
        """Return the largest diameter of the groove's bottom, up to the ``widest``, mm, round which a ring that is sold is not slack.

        Rings of a cord that no standard has are taken to be sold in any size.
        """
        low, high = (1 + stretch for stretch in STRETCH)
        sizes = [min(widest, high * inside) for _, inside in list_rings(self.cord) if low * inside <= widest]
        return max(sizes, default=widest)

    def fit_ring(self, bore: float, gap: float, plug: float) -> "Seal":
        """Return the seal of a plug as thick as given, with a gap to the radius of its bore; mm.

        A stretched cord is thinner: its volume stays.
        """
        groove, (low, high) = 2 * (bore - self.depth), (1 + STRETCH[0] - 1e-6, 1 + STRETCH[1] + 1e-6)
        fitting = [ring for ring in list_rings(self.cord) if low * ring[1] <= groove <= high * ring[1]]
        name, inside = fitting[-1] if fitting else (None, groove / (1 + sum(STRETCH) / 2))
        cord, deep = self.cord * math.sqrt(inside / groove), self.depth - gap
        room = self.bottom * self.depth + deep * deep / 2 + gap * deep
        shares = groove / inside - 1, 1 - self.depth / cord, math.pi / 4 * cord * cord / room
        return Seal(self.cord, name, inside, groove, plug - deep, *shares)


@dataclass(frozen=True)
class Seal:
    """An O-ring in its groove, whose bottom has a diameter of ``groove_mm``, with a thickness of ``wall_mm`` under it.

    ``ring`` names the one that is sold, with its diameter ``inside_mm``; ``None`` if no standard has its cord. The last three are shares.
    """

    cord_mm: float
    ring: str | None
    inside_mm: float
    groove_mm: float
    wall_mm: float
    stretch: float
    squeeze: float
    fill: float

    @property
    def volume(self) -> float:
        """Volume of the ring, mm3: that of a torus, which stays when it is stretched and squeezed."""
        return math.pi**2 / 4 * self.cord_mm**2 * (self.inside_mm + self.cord_mm)

    @property
    def mass(self) -> float:
        """Mass of the ring, kg."""
        return 1e-9 * NITRILE * self.volume

    def describe(self) -> dict[str, Any]:
        """Return all of it in SI units, with a ``summary``."""
        facts = {k.removesuffix("_mm"): v / 1000 if k.endswith("_mm") else v for k, v in vars(self).items()}
        bought = f"{self.ring or 'cord'}, {self.inside_mm:.4g} x {self.cord_mm:g} mm, {1000 * self.mass:.2f} g"
        groove = f"groove {self.groove_mm:.2f} mm across, {self.wall_mm:.2f} mm of wall under it"
        fits = f"stretch {self.stretch:.0%}, squeeze {self.squeeze:.0%}, fill {self.fill:.0%}"
        return {**facts, "mass": self.mass, "summary": f"{bought}; {groove}; {fits}"}


def choose_gland(cord: float) -> Gland:
    """Return the gland for a cord, mm: by the standard, and in proportion between and beyond its cords."""
    cords = [section["cord"] for section in _SECTIONS]
    ratios = [[section[key] / section["cord"] for section in _SECTIONS] for key in ("depth", "width")]
    depth, width = (cord * float(np.interp(cord, cords, ratio)) for ratio in ratios)
    return Gland(cord, depth, width)


def list_rings(cord: float) -> list[tuple[str, float]]:
    """Names and inside diameters (mm) of the rings of a cord, the smallest first."""
    section = next((section for section in _SECTIONS if abs(section["cord"] - cord) < _NEAR), None)
    sizes = section["inside"] if section else []
    return [(f"AS568-{number:03}", inside) for number, inside in enumerate(sizes, section["first"] if section else 0)]
