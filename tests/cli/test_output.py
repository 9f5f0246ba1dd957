"""Tables for people: on a terminal they fit it, elsewhere nothing is folded."""

import io
import re
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.cli.output import print_table, print_text

RESULTS = ("target", "x m", "y m", "z m", "fitness %", "error % of d_max", "disturbed: mean", "worst", "closest mm")


class Terminal(io.StringIO):
    """A standard output that is a terminal."""

    def isatty(self):
        return True


def printed(header, rows, right, columns):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stdout", out := Terminal())
        patch.setenv("COLUMNS", str(columns))
        patch.setenv("TERM", "xterm")
        print_table(header, rows, right)
    return re.sub(r"\x1b\[[\d;]*m", "", out.getvalue()).splitlines()


def test_the_results_of_a_robust_run_find_room_in_80_columns_in_a_line_for_each_target():
    rows = [(f"TP{n}", "8.5", "0", "-0.25", "100.000", "12.345", "12.345", "12.345", "1234.5") for n in range(1, 11)]
    lines = printed(RESULTS, rows, range(1, 9), 80)
    assert max(map(len, lines)) <= 80
    assert len(lines) == len(rows) + 3  # a heading of two lines, and a rule
    assert [line.split() for line in lines[3:]] == [list(row) for row in rows]


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=6), st.integers(80, 120))
def test_no_number_is_folded_where_text_can_be(numbers, columns):
    cells = [f"{number:.3g}" for number in numbers]
    header = ["what it is", *("a long heading" for _ in cells)]
    lines = printed(header, [["word " * 30, *cells]], range(1, len(header)), columns)
    assert max(map(len, lines)) <= columns
    assert any(line.split()[-len(cells) :] == cells for line in lines)


def test_text_is_no_markup():
    assert printed(["[b]name[/b]"], [["[red]A[/red]"]], (), 80)[2].strip() == "[red]A[/red]"


def test_a_long_line_is_folded_between_words_on_a_terminal_alone(capsys):
    text = "10 of 10 targets are reached: " + "an error of at most 1 % of the farthest distance; " * 3
    print_text(text)
    assert capsys.readouterr().out == text + "\n"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "stdout", out := Terminal())
        patch.setenv("COLUMNS", "80")
        patch.setenv("TERM", "xterm")
        print_text(text)
    lines = out.getvalue().splitlines()
    assert max(map(len, lines)) <= 80
    assert " ".join(line.strip() for line in lines).split() == text.split()
