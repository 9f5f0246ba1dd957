"""What a notebook shows of a value: pictures and tables as HTML."""

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape


def show_picture(svg: str, told: str) -> str:
    """Return a picture as HTML, with ``told`` for those who do not see it.

    As an image of its own: the identifiers of drawings side by side on one page would get mixed up.
    """
    data = b64encode(svg.encode()).decode()
    return f'<img src="data:image/svg+xml;base64,{data}" alt="{escape(told)}" style="max-width:100%; background:white">'


def show_table(header: Sequence[str], rows: Iterable[Sequence[str]], title: str = "") -> str:
    """Return a table as HTML, under a title; what stands in the cells is text."""
    caption = f"<caption>{escape(title)}</caption>" if title else ""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
