"""Pictures and tables as HTML, for notebooks."""

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape


def show_picture(svg: str, alt: str) -> str:
    """Return an SVG picture as HTML, with the alternative text ``alt``.

    The picture is a separate image, because identifiers of several inline drawings on one page would collide.
    """
    data = b64encode(svg.encode()).decode()
    return f'<img src="data:image/svg+xml;base64,{data}" alt="{escape(alt)}" style="max-width:100%; background:white">'


def show_table(header: Sequence[str], rows: Iterable[Sequence[str]], title: str = "") -> str:
    """Return a table as HTML, with a caption; the content of header and cells is plain text."""
    caption = f"<caption>{escape(title)}</caption>" if title else ""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
