"""The hand-written words of README.md, CONTRIBUTING.md and the pages, counted and limited. ``-s`` prints them."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

LIMIT = 43_222
LIMITS = {"dataflow.md": 1800, "validation.md": 2000, "study-files.md": 1200, "printing.md": 2400}
# Pages that are made from the program; cli.md, the reference of all commands, is so for the most part.
GENERATED = ("cli.md", "examples.md", "plugins", "reference.md", "study-keys.md")

_GENERATED = re.compile(r"<!-- generated: .*?-->.*?<!-- end -->", re.DOTALL)


def count_words(text):
    """Words of a page, with its examples, and the outputs and tables that tests put there, but without its generated parts.

    A word holds a letter or a digit: the bars of a table are not words.
    """
    return sum(any(map(str.isalnum, word)) for word in _GENERATED.sub("", text).split())


@pytest.fixture(scope="module")
def words(pages):
    texts = {name: text for name, text in pages.items() if not name.startswith(GENERATED)}
    texts |= {name: (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "CONTRIBUTING.md")}
    return {name: count_words(text) for name, text in texts.items()}


def test_all_pages_together_are_a_book_of_one_afternoon(words):
    print("", *(f"{n:6d}  {name}" for name, n in sorted(words.items(), key=lambda w: -w[1])), sep="\n")
    print(f"{sum(words.values()):6d}  words, of at most {LIMIT}")
    assert sum(words.values()) <= LIMIT


@pytest.mark.parametrize("page", LIMITS)
def test_long_pages_stay_short(page, words):
    assert words[page] <= LIMITS[page]


def test_only_generated_parts_are_not_counted():
    text = "one two\n\n<!-- generated: keys -->\n\n| three |\n\n<!-- end -->\n\nfour `five`\n"
    assert count_words(text) == 4
    assert count_words("<!-- flights -->\n\n| 1 mm |\n\n<!-- end of flights -->\n") == 6
