"""Colours of all pictures.

The hues are those of Okabe and Ito, which people with any colour vision can distinguish. Text is in ``INK``,
``MUTED`` or ``VERMILLION``: the light hues are too pale to read on white.
"""

INK = "#1f2a36"
MUTED = "#586673"
GRID = "#e6ebef"
WATER = "#f1f7fb"
WALL = "#4a5967"
"""Neutral colours: ``INK`` and ``MUTED`` of text, ``GRID`` of lines behind data, ``WATER`` and ``WALL`` of pipes."""

WRONG = "#b3261e"
"""Colour of what cannot work, such as a target outside the pipe."""

BLUE = "#0072b2"
ORANGE = "#e69f00"
VERMILLION = "#d55e00"
"""``BLUE`` of what is measured, ``ORANGE`` of bodies and marks, ``VERMILLION`` of targets and warnings."""

SERIES = (
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#e69f00",
    "#56b4e9",
    "#1f2a36",
    "#882255",
    "#999933",
    "#7f8b96",
)
"""Seven of Okabe and Ito (yellow is too pale on white), then wine, olive and grey."""

RAMP = ("#440154", "#443983", "#31688e", "#21918c", "#35b779", "#90d743", "#fde725")
"""Viridis, whose steps differ in lightness for any colour vision; closer is darker."""


def tint(colour: str, strength: float) -> str:
    """Return ``colour`` mixed into white: 1 is the colour itself, 0 is white."""
    channels = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(255 - strength * (255 - c)):02x}" for c in channels)
