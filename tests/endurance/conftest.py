"""What the long trials share: their tables in docs/validation.md."""

import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "validation.md"


def _replace(title: str, change: Callable[[list[str]], list[str]]) -> None:
    """Put other lines into a generated part of the page, which are made from those that it has."""
    marked = re.compile(rf"(<!-- generated: {title} -->\n\n)(.*?)(\n\n<!-- end -->)", re.DOTALL)
    text = PAGE.read_text(encoding="utf-8")
    found = marked.search(text)
    assert found is not None, f"{PAGE.name} has no place for '{title}'"
    lines = "\n".join(change(found[2].split("\n")))
    PAGE.write_text(text[: found.start(2)] + lines + text[found.end(2) :], encoding="utf-8")


@pytest.fixture
def show_row() -> Callable[..., None]:
    """Print a row of a table; with UPDATE_DOCS=1 put it into the page, in the place of one that begins likewise."""

    def show(title: str, *cells: object) -> None:
        row = f"| {' | '.join(map(str, cells))} |"
        print("\n" + row)

        def change(lines: list[str]) -> list[str]:
            kept = [line for line in lines[2:] if not line.startswith(f"| {cells[0]} |")]
            return [*lines[:2], *sorted([*kept, row])]

        if os.environ.get("UPDATE_DOCS") == "1":
            _replace(title, change)

    return show
