"""What a command prints: one JSON document, or text for people."""

import json
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from driftform.errors import escape_controls

if TYPE_CHECKING:
    from driftform.types import WrittenFile

__all__ = ["escape_controls", "print_json", "print_table", "print_text", "reserve_stdout"]

_reserved: list[TextIO] = []


@contextmanager
def reserve_stdout() -> Iterator[None]:
    """Keep stdout for the document of :func:`print_json`; whatever else is printed meanwhile goes to stderr.

    That includes plugins, the libraries that they call, and the processes that they start.
    """
    document = sys.stdout
    document.flush()
    has_descriptor = document is sys.__stdout__
    if has_descriptor:
        # Not undone: what libraries keep in buffers of their own is written when the process ends.
        document = os.fdopen(os.dup(1), "w", encoding=document.encoding)
        os.dup2(2, 1)
    _reserved.append(document)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        _reserved.pop()
        if has_descriptor:
            with suppress(OSError):
                document.close()


def print_json(document: Mapping[str, Any]) -> None:
    """Print one JSON document on stdout; arrays become lists, numbers that are not finite ``null``."""
    text = json.dumps(_to_plain(document), indent=1, allow_nan=False)
    print(text, file=_reserved[-1] if _reserved else sys.stdout, flush=True)


def print_table(header: Sequence[str], rows: Iterable[Sequence[str]], right: Sequence[int] = ()) -> None:
    """Print a table on stdout; the columns ``right`` are flush right.

    On a terminal it is drawn by rich and fits the width: headings and text are folded, never a number of ``right``.
    Elsewhere the columns are padded, and nothing is folded.
    """
    rows = [[escape_controls(cell) for cell in row] for row in rows]
    if sys.stdout.isatty():
        _draw_table(header, rows, right)
        return
    widths = [max(len(row[i]) for row in [list(header), *rows]) for i in range(len(header))]
    for row in [list(header), *rows]:
        cells = [c.rjust(w) if i in right else c.ljust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True))]
        print("  ".join(cells).rstrip())


def _draw_table(header: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[int]) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    for number, title in enumerate(header):
        whole = max((len(row[number]) for row in rows), default=0) if number in right else None
        table.add_column(Text(title), justify="left" if whole is None else "right", min_width=whole, overflow="fold")
    for row in rows:
        table.add_row(*map(Text, row))
    Console(highlight=False).print(table)


def print_files(files: "Iterable[WrittenFile]", folder: Path) -> None:
    """Print a line for each file with its plain facts; of files in folders of ``folder`` only those that have facts."""
    for file in files:
        facts = ", ".join(f"{key} {shorten(fact)}" for key, fact in file.facts.items() if not isinstance(fact, dict))
        if facts or Path(file.path).parent == folder:
            print(f"{file.path}: {facts}" if facts else file.path)


def shorten(value: object) -> str:
    """Return a fact in few characters."""
    if isinstance(value, list | tuple):
        names = any(isinstance(item, str) for item in value)
        return (", " if names else " x ").join(map(shorten, value))
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def print_text(text: str) -> None:
    """Print a line on stdout; on a terminal it is folded between words."""
    if not sys.stdout.isatty():
        print(text)
        return
    from rich.console import Console
    from rich.text import Text

    Console(highlight=False).print(Text(text))


def _to_plain(value: Any) -> Any:
    import numpy as np

    match value:
        case Mapping():
            return {str(key): _to_plain(item) for key, item in value.items()}
        case np.ndarray():
            return _to_plain(value.tolist())
        case np.generic():
            return _to_plain(value.item())
        case float():
            return value if np.isfinite(value) else None
        case list() | tuple():
            return [_to_plain(item) for item in value]
        case _:
            return value if value is None or isinstance(value, bool | int | str) else str(value)
