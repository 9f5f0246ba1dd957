"""The report of a passage or a fleet: one HTML page with its figures and tables, which loads nothing over the network."""

from collections.abc import Sequence
from importlib.resources import files
from typing import Any, NamedTuple

from driftform.figures import style, svg


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


def report_html(title: str, text: Sequence[str | TextTable], figures: Sequence[tuple[str, str]], is_body: bool) -> str:
    """Return the page of a result.

    ``text`` is what a command prints, of which lines come first; ``figures`` are headings and SVG pictures; ``is_body`` is
    whether it is about bodies, in place of water.
    """
    return render_template(
        "page.html",
        title=title,
        script=files("driftform_networks").joinpath("zoom.js").read_text(encoding="utf-8"),
        style=files("driftform.report").joinpath("page.css").read_text(encoding="utf-8"),
        lead=[part for part in text if isinstance(part, str)],
        tables=[part for part in text if not isinstance(part, str)],
        figures=figures,
        is_body=is_body,
    )
