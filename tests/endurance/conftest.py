"""What the long trials share: their tables in docs/validation.md."""

import os

import pytest
from pages import split_page


@pytest.fixture
def show_row():
    """Print a row of a table; with UPDATE_DOCS=1 put it into the page, in the place of one that begins likewise."""

    def show(title, *cells):
        row = f"| {' | '.join(map(str, cells))} |"
        print("\n" + row)
        if os.environ.get("UPDATE_DOCS") == "1":
            page, head, table, tail = split_page(title)
            lines = table.split("\n")
            kept = [line for line in lines[2:] if not line.startswith(f"| {cells[0]} |")]
            page.write_text(head + "\n".join([*lines[:2], *sorted([*kept, row])]) + tail, encoding="utf-8")

    return show
