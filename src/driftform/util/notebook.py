"""Pictures and tables as HTML, for notebooks, and what changes there while a cell runs."""

import sys
import time
from base64 import b64encode
from collections.abc import Callable, Iterable, Sequence
from html import escape

UPDATE_S = 0.25
"""Shortest time between two updates of a display, s."""


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


def find_display() -> Callable[[object, bool], None] | None:
    """Return a function that shows a value below the running cell, in place of the one before; ``None`` elsewhere.

    It skips values that follow too soon, unless its second argument is true.
    """
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if getattr(shell, "kernel", None) is None:
        return None
    from IPython.display import display

    handle, shown = None, 0.0

    def show(value: object, at_once: bool) -> None:
        nonlocal handle, shown
        if at_once or time.monotonic() > shown + UPDATE_S:
            shown = time.monotonic()
            if handle is None:
                handle = display(value, display_id=True)  # type: ignore[no-untyped-call]
            else:
                handle.update(value)

    return show
