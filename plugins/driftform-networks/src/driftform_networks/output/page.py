"""The report of a passage or a fleet: one HTML page with its figures and tables, which loads nothing over the network."""

from collections.abc import Sequence
from importlib.resources import files
from typing import NamedTuple

from driftform.figures import svg


class TextTable(NamedTuple):
    """A table for people: a header, rows of text, and the columns that are flush right."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: Sequence[int] = ()


def report_html(title: str, text: Sequence[str | TextTable], figures: Sequence[tuple[str, str]], is_body: bool) -> str:
    """Return the page of a result.

    ``text`` is what a command prints, of which lines come first; ``figures`` are headings and SVG pictures; ``is_body`` is
    whether it is about bodies, in place of water.
    """
    return svg.fill_template(
        "driftform_networks.output",
        "page.html",
        title=title,
        script=files("driftform_networks.output").joinpath("zoom.js").read_text(encoding="utf-8"),
        style=files("driftform.search.report").joinpath("page.css").read_text(encoding="utf-8"),
        lead=[part for part in text if isinstance(part, str)],
        tables=[part for part in text if not isinstance(part, str)],
        figures=figures,
        is_body=is_body,
    )
