"""Colours of parts: one for each, the same in every format."""

from driftform.figures import style


def colour_of(index: int) -> str:
    """Return the colour of the part at ``index``, as ``#rrggbb``."""
    return style.SERIES[index % len(style.SERIES)]


def channels(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue of ``#rrggbb``, from 0 to 1, as screens take them."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


def decode_srgb(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue proportional to light, from 0 to 1: sRGB decoded (IEC 61966-2-1)."""
    red, green, blue = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels(colour))
    return red, green, blue
