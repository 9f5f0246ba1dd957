"""Pictures as files: SVG, and PNG beside it if the extra ``png`` is installed."""

from pathlib import Path

from driftform.util.files import write_text, write_whole

ZOOM = 2.0
"""PNG pixels per px of a picture: sharp on high-resolution screens, and 150 dpi at 15 cm."""

DPI = 96.0
"""px of a picture for each inch of a size in mm, as CSS defines it; without it resvg refuses sizes in mm."""


def write_picture(path: Path, svg: str) -> tuple[Path, ...]:
    """Write an SVG picture, and the same as PNG if the extra ``png`` is installed; return the paths.

    Raises:
        OSError: if a file cannot be written.
    """
    write_text(path, svg)
    png = rasterise(svg)
    if png is None:
        return (path,)
    image = path.with_suffix(".png")
    write_whole(image, lambda part: part.write_bytes(png))
    return path, image


def rasterise(svg: str) -> bytes | None:
    """Return a picture as PNG, or ``None`` if the extra ``png`` is not installed."""
    try:
        from resvg_py import svg_to_bytes
    except ImportError:
        return None
    # resvg does not know system-ui, the first font of the picture; this sets what sans-serif means.
    return bytes(svg_to_bytes(svg_string=svg, zoom=ZOOM, dpi=DPI, sans_serif_family="DejaVu Sans"))
