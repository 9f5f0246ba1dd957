"""The report of a passage or a fleet: one HTML page with its figures and tables, which loads nothing over the network."""

from collections.abc import Sequence
from importlib.resources import files
from typing import Any, NamedTuple

from driftform.figures import style, svg

WATER = (
    "Flows are those of EPANET; water mixes completely at each node.",
    "Without --unsteady the flows remain those of the hour of the release.",
)
"""Assumptions of all passages."""

BODIES = (
    *WATER,
    "In straight runs a body moves as in flights of its shape at that bore, speed and slope; a body so neutral that "
    "turbulence mixes it is anywhere in the bore.",
    "At a tee or wye a body goes as in flights of its shape through one like it, in ideal flow without swirl and "
    "separation. At other junctions, and if it is mixed and narrow, it goes with the water around its centre, which flat "
    "surfaces divide among the outlets. Two bodies never meet.",
    "A body that is wider than the service pipes does not leave with the demand; it ends where the water of a pipe does.",
    "Angles of fittings are those of the map if it is drawn to scale, else 90 degrees for each branch; the side where a "
    "branch leaves is an input, --branch.",
)
"""Assumptions of the routes of bodies."""


class TextTable(NamedTuple):
    """A table for people: a header, rows of text, and the columns that are flush right."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: Sequence[int] = ()


def render_template(name: str, **values: Any) -> str:
    """Return a template of this package with values, and with the colours and fonts of all pictures."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("driftform_networks", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["n"] = svg.format_number
    colours = ("ink", "muted", "grid", "blue", "orange", "vermillion")
    look = {name: getattr(style, name.upper()) for name in colours} | {"fonts": svg.FONTS}
    return environment.get_template(name).render(look | values)


def report_html(
    title: str,
    text: Sequence[str | TextTable],
    figures: Sequence[tuple[str, str]],
    assumptions: Sequence[str],
) -> str:
    """Return the page of a result.

    Args:
        text: lines and tables as a command prints them; the lines come first.
        figures: headings and SVG pictures.
    """
    return render_template(
        "page.html",
        title=title,
        script=files("driftform_networks").joinpath("zoom.js").read_text(encoding="utf-8"),
        style=files("driftform.report").joinpath("page.css").read_text(encoding="utf-8"),
        lead=[part for part in text if isinstance(part, str)],
        tables=[part for part in text if not isinstance(part, str)],
        figures=figures,
        assumptions=assumptions,
    )
