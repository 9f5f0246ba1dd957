"""Colours, lines and pages of all pictures.

The hues are those of Okabe and Ito, which people with any colour vision can distinguish. Text is in ``INK``,
``MUTED`` or ``VERMILLION``: the light hues are too pale to read on white.
"""

from dataclasses import dataclass
from typing import Self

PX_PER_MM = 96 / 25.4
"""px of a picture per mm: CSS defines the pixel as 1/96 inch, so a picture can be printed to scale."""

INK = "#1f2a36"
MUTED = "#586673"
GRID = "#e6ebef"
WATER = "#f1f7fb"
WALL = "#4a5967"
"""Neutral colours: ``INK`` and ``MUTED`` of text, ``GRID`` of lines under data, ``WATER`` and ``WALL`` of pipes."""

WRONG = "#b3261e"
"""Colour of what cannot work, such as a target outside the pipe."""

BLUE = "#0072b2"
ORANGE = "#e69f00"
VERMILLION = "#d55e00"
"""``BLUE`` of what is measured, ``ORANGE`` of bodies and marks, ``VERMILLION`` of targets and warnings."""

SERIES = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#1f2a36", "#882255", "#999933",
    "#7f8b96",
)  # fmt: skip
"""Seven of Okabe and Ito (yellow is too pale on white), then wine, olive and grey."""

DASHES = ("none", "8 3", "2.5 2.5", "9 3 2 3", "14 3 4 3")
"""Dashes of the lines of a figure for a paper, px: of two series with the same ones the colours differ for anyone."""

RAMP = ("#440154", "#443983", "#31688e", "#21918c", "#35b779", "#90d743", "#fde725")
"""Viridis, whose steps differ in lightness for any colour vision; closer is darker."""


@dataclass(frozen=True)
class Page:
    """Where a picture is read: on a screen, or as a figure of a paper, without a title and with text of 8 pt.

    Attributes:
        width: of the picture, px.
        width_mm: of a figure in print, mm; ``None`` on a screen.
    """

    width: float = 900.0
    width_mm: float | None = None

    @classmethod
    def find(cls, width_mm: float | None) -> Self:
        """Return the page of a figure ``width_mm`` wide, on which 12 px are 8 pt; with ``None`` that of a screen."""
        return cls() if width_mm is None else cls(width_mm * PX_PER_MM * 9 / 8, width_mm)

    @property
    def is_paper(self) -> bool:
        """Whether it is a figure of a paper."""
        return self.width_mm is not None

    def choose_dash(self, number: int) -> str:
        """Return the dashes of a series; on a screen series differ in colour alone."""
        return DASHES[number % len(DASHES)] if self.is_paper else ""


SCREEN = Page()
"""The page of a picture that says nothing else."""


def tint(colour: str, strength: float) -> str:
    """Return ``colour`` mixed into white: 1 is the colour itself, 0 is white."""
    channels = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(255 - strength * (255 - c)):02x}" for c in channels)
