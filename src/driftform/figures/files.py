"""Pictures as files: SVG for every use, and PNG beside it where the extra ``png`` is installed."""

from pathlib import Path

from driftform.util.files import write_text, write_whole

ZOOM = 2.0
"""PNG pixels for each px of a picture: sharp on dense screens, and 150 dpi at 15 cm."""


def write_picture(path: Path, svg: str) -> tuple[Path, ...]:
    """Write an SVG picture, and the same as PNG where that can be made; return the files.

    Raises
    ------
    OSError
        where a file cannot be written.
    """
    write_text(path, svg)
    png = rasterise(svg)
    if png is None:
        return (path,)
    image = path.with_suffix(".png")
    write_whole(image, lambda part: part.write_bytes(png))
    return path, image


def rasterise(svg: str) -> bytes | None:
    """Return a picture as PNG, ``None`` where the extra ``png`` is not installed."""
    try:
        from resvg_py import svg_to_bytes
    except ImportError:
        return None
    # The first family of the picture's own list is what the system calls its own, and nobody else knows.
    return bytes(svg_to_bytes(svg_string=svg, zoom=ZOOM, sans_serif_family="DejaVu Sans"))
