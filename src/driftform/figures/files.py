"""Pictures as files: SVG, and also PNG, or PDF for a paper, if the extras ``png`` and ``pdf`` are installed."""

from pathlib import Path

from driftform.figures.style import SCREEN, Page
from driftform.util.files import write_text, write_whole

ZOOM = 2.0
"""PNG pixels per px of a picture: sharp on high-resolution screens, and 150 dpi at 15 cm."""

DPI = 96.0
"""px of a picture per inch of a size in mm, as CSS defines it; without it resvg refuses sizes in mm."""


def write_picture(path: Path, svg: str, page: Page = SCREEN, png: bool = True) -> tuple[Path, ...]:
    """Write an SVG picture, and the same as PNG or, for a paper, as PDF, if the extra is installed; return the paths.

    Raises OSError if a file cannot be written.
    """
    write_text(path, svg)
    content = make_pdf(svg) if page.is_paper else rasterise(svg) if png else None
    if content is None:
        return (path,)
    converted = path.with_suffix(".pdf" if page.is_paper else ".png")
    write_whole(converted, lambda part: part.write_bytes(content))
    return path, converted


def rasterise(svg: str) -> bytes | None:
    """Return a picture as PNG, or ``None`` if the extra ``png`` is not installed."""
    try:
        from resvg_py import svg_to_bytes
    except ImportError:
        return None
    # resvg does not know system-ui, the first font of the picture; this sets what sans-serif means.
    return bytes(svg_to_bytes(svg_string=svg, zoom=ZOOM, dpi=DPI, sans_serif_family="DejaVu Sans"))


def make_pdf(svg: str) -> bytes | None:
    """Return a picture as a page of PDF in its size, or ``None`` if the extra ``pdf`` or the Cairo library is not installed."""
    try:
        from cairosvg import svg2pdf
    except (ImportError, OSError):
        return None
    return bytes(svg2pdf(bytestring=svg.encode(), dpi=DPI))
