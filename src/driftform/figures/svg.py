"""SVG as text: the same elements give the same bytes.

Several pictures share one HTML page, so nothing here uses an ``id`` or a style sheet: both would affect the other
pictures. Nothing uses a transform either; every number is in px of the ``viewBox``.
"""

import re
from functools import lru_cache
from itertools import groupby
from typing import Any, Literal
from xml.etree import ElementTree as ET

import numpy as np
import numpy.typing as npt

from driftform.figures import style
from driftform.figures.style import PX_PER_MM, SCREEN, Page

FONTS = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
"""Fonts of pictures on a screen: those of the reader's system."""

PAPER_FONTS = "Arial, Helvetica, 'Liberation Sans', sans-serif"
"""Fonts of figures for papers: Arial, or those with its widths."""

_NOT_XML = "[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"


def format_number(value: float) -> str:
    """Return ``value`` rounded to a hundredth, without trailing zeros or a negative zero."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def start_document(
    width: float,
    height: float,
    title: str,
    description: str,
    unit: Literal["px", "mm"] = "px",
    page: Page = SCREEN,
    header: float = 0.0,
) -> ET.Element:
    """Return an empty white picture of ``width`` by ``height`` px.

    With ``unit`` mm, the natural size is in millimetres, so that printing keeps the scale. A figure for a paper is as wide
    as its ``page``, and begins below the ``header``, px, where pictures on a screen have their title.
    """
    size = {"px": 1.0, "mm": 1 / PX_PER_MM}[unit]
    suffix, top = unit if unit == "mm" else "", 0.0
    if page.width_mm is not None:
        size, suffix, top = page.width_mm / width, "mm", header
        height -= header
    root = ET.Element(
        "svg",
        {
            "xmlns": "http://www.w3.org/2000/svg",
            "width": format_number(width * size) + suffix,
            "height": format_number(height * size) + suffix,
            "viewBox": f"0 {format_number(top)} {format_number(width)} {format_number(height)}",
            "role": "img",
            "font-family": PAPER_FONTS if page.is_paper else FONTS,
        },
    )
    add(root, "title", title)
    add(root, "desc", description)
    add(root, "rect", x=0, y=top, width=width, height=height, fill="#ffffff")
    return root


def add(parent: ET.Element, tag: str, content: str = "", **attributes: str | float) -> ET.Element:
    """Append an element; ``stroke_width`` becomes ``stroke-width``, ``class_`` becomes ``class``, empty texts are left out."""
    element = ET.SubElement(parent, tag)
    for key, value in attributes.items():
        if value == "":
            continue
        name = key.rstrip("_").replace("_", "-")
        element.set(name, _replace_illegal(value) if isinstance(value, str) else format_number(value))
    if content:
        element.text = _replace_illegal(content)
    return element


def add_line(
    parent: ET.Element, data: str, stroke: str, width: float, class_: str = "", **attributes: str | float
) -> None:
    """Append an unfilled line ``width`` px wide; ``data`` is as from :func:`path_data`."""
    add(parent, "path", "", class_=class_, d=data, fill="none", stroke=stroke, stroke_width=width, **attributes)


def add_segment(
    parent: ET.Element,
    x1: float,
    y1: float,
    x2: float,
    y2: float,
    stroke: str,
    width: float | None = None,
    class_: str = "",
    **attributes: str | float,
) -> None:
    """Append a straight line between two points, ``width`` px wide, 1 px by default."""
    attributes = {"stroke": stroke, "stroke_width": "" if width is None else width, **attributes}
    add(parent, "line", "", class_=class_, x1=x1, y1=y1, x2=x2, y2=y2, **attributes)


def add_circle(
    parent: ET.Element,
    x: float,
    y: float,
    radius: float,
    fill: str,
    stroke: str = "",
    width: float = 1,
    class_: str = "",
) -> None:
    """Append a circle about a point; without ``stroke`` it has no edge, otherwise one ``width`` px wide."""
    wide = width if stroke else ""
    add(parent, "circle", "", class_=class_, cx=x, cy=y, r=radius, fill=fill, stroke=stroke, stroke_width=wide)


def path_data(points: npt.ArrayLike, closed: bool = False) -> str:
    """Return path data through ``points``, (n, 2) in px; successive points that round to the same numbers are merged."""
    pairs = (" ".join(map(format_number, point)) for point in np.asarray(points, dtype=np.float64).tolist())
    corners = [pair for pair, _ in groupby(pairs)]
    if not corners:
        return ""
    # A single point is doubled: without a line there are no round caps to draw.
    corners += corners if len(corners) == 1 else []
    return "M" + "L".join(corners) + ("Z" if closed else "")


def lines_data(lines: npt.NDArray[np.float64], closed: bool = False) -> str:
    """Return path data of many lines with equally many points, (lines, n, 2) in px, each as from :func:`path_data`."""
    return "".join(path_data(line, closed) for line in lines)


def draw_template(parent: ET.Element, package: str, name: str, **values: Any) -> None:
    """Append the elements of the template ``NAME.svg`` of a package; see :func:`fill_template`."""
    parent.extend(ET.fromstring(f"<svg>{fill_template(package, f'{name}.svg', **values)}</svg>"))


def fill_template(package: str, file: str, **values: Any) -> str:
    """Return the text of a file in the folder ``templates`` of a package, a template of Jinja.

    Numbers become those of :func:`format_number`, and texts are escaped, but for those of ``.txt``. Templates know the colours of
    :mod:`driftform.figures.style` by name, ``tint``, and :func:`path_data` as ``path``.
    """
    return str(_open_templates(package).get_template(file).render(values))


@lru_cache
def _open_templates(package: str) -> Any:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    def finalize(value: Any) -> Any:
        if isinstance(value, int | float | np.number):
            return format_number(float(value))
        return _replace_illegal(value) if type(value) is str else value

    loader = PackageLoader(package.partition(".")[0], "/".join([*package.split(".")[1:], "templates"]))
    environment = Environment(
        loader=loader,
        autoescape=lambda name: name is None or not name.endswith(".txt"),
        undefined=StrictUndefined,
        finalize=finalize,
        trim_blocks=True,
    )
    colours = {name: value for name, value in vars(style).items() if name.isupper()}
    environment.globals |= {**colours, "tint": style.tint, "path": path_data, "number": format_number}
    return environment


def render(root: ET.Element) -> str:
    """Return the picture as text, to write as UTF-8 or to place in an HTML page unchanged."""
    ET.indent(root, " ")
    return ET.tostring(root, encoding="unicode") + "\n"


def _replace_illegal(text: str) -> str:
    """Replace characters that XML cannot hold, even escaped, such as most control characters."""
    return re.sub(_NOT_XML, "�", text)
