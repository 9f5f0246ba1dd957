"""What tests write into the pages of docs: whole pages, and parts between a line with their title and one where they end."""

import os
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


def split_page(title, page=None):
    """Return a page that has a part, the text before the lines of the part, they themselves, and the text after them."""
    name = re.escape(title)
    part = re.compile(rf"(.*<!-- (?:generated: )?{name} -->\n\n)(.*?)(\n\n<!-- end(?: of {name})? -->.*)", re.DOTALL)
    for path in [page] if page else sorted(DOCS.glob("*.md")):
        if found := part.fullmatch(path.read_text(encoding="utf-8")):
            return path, found[1], found[2], found[3]
    raise AssertionError(f"no page of docs has a place for '{title}'")


def keep_up_to_date(path, expected):
    """Compare a page with what it should be; with UPDATE_DOCS=1 make it so."""
    found = path.read_text(encoding="utf-8") if path.exists() else ""
    if found != expected and os.environ.get("UPDATE_DOCS") == "1":
        path.write_text(expected, encoding="utf-8")
        return
    assert found == expected, f"{path.name} is out of date: run this test with UPDATE_DOCS=1"


@pytest.fixture
def up_to_date():
    """Compare a page with what it should be; with UPDATE_DOCS=1 make it so."""
    return keep_up_to_date


@pytest.fixture
def published():
    """Check that lines are those of the part of a page with their title; with UPDATE_DOCS=1 put them there."""

    def check(title, lines, page=None):
        path, head, _, tail = split_page(title, page)
        keep_up_to_date(path, head + "\n".join(lines) + tail)

    return check


@pytest.fixture
def publish():
    """Show lines of Markdown; with UPDATE_DOCS=1 put them into the part of a page with their title, too."""

    def show(title, lines):
        print("\n" + "\n".join(lines))
        if os.environ.get("UPDATE_DOCS") == "1":
            path, head, _, tail = split_page(title)
            path.write_text(head + "\n".join(lines) + tail, encoding="utf-8")

    return show
