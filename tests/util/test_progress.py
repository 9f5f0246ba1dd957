"""How far long work is."""

import re
import time
from collections.abc import Iterator
from contextlib import closing

import pytest

from driftform.util import progress
from driftform.util.progress import count_progress, print_regularly, show_progress, track_progress


def test_short_work_prints_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert list(track_progress("abc", 3, "letters")) == ["a", "b", "c"]
    assert capsys.readouterr().err == ""


def test_longer_work_prints_its_progress(capsys: pytest.CaptureFixture[str]) -> None:
    assert len(list(track_progress(range(50), 50, "numbers", delay=0.0))) == 50
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 10
    assert lines[-1] == "50/50 numbers, 0 s"
    assert re.fullmatch(r"25/50 numbers, 0 s, 0 s left", lines[4])


def test_more_items_than_announced_are_accepted(capsys: pytest.CaptureFixture[str]) -> None:
    list(track_progress(range(12), 10, "numbers", delay=0.0))
    assert capsys.readouterr().err.splitlines()[-1] == "12/12 numbers, 0 s"


def test_closing_the_iterator_closes_the_iterated_items() -> None:
    ended = []

    def ones() -> Iterator[int]:
        try:
            while True:
                yield 1
        finally:
            ended.append(True)

    with closing(track_progress(ones(), 10, "ones", delay=0.0)) as seen:
        assert next(seen) == 1
    assert ended == [True]


def test_a_long_step_does_not_keep_the_lines_back(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "LONGEST_SILENCE_S", 0.1)
    with count_progress("steps") as show:
        show(1, 100)
        time.sleep(1.0)
    lines = capsys.readouterr().err.splitlines()
    assert 3 <= len(lines) <= 10 and set(lines) <= {"1/100 steps, 0 s", "1/100 steps, 1 s"}


def test_a_line_that_was_printed_delays_the_next(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "LONGEST_SILENCE_S", 30.0)
    with print_regularly(lambda: "now") as show:
        show()
    assert capsys.readouterr().err == "now\n"


def test_the_time_left_is_that_of_the_steps_after_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    count = progress.Count("flights")
    # The first flight compiles for 50 s, the others take 2 s each.
    now = 150.0
    count.set(1, 101)
    assert repr(count) == "1/101 flights, 50 s"
    now = 170.0
    count.set(11, 101)
    assert repr(count) == "11/101 flights, 1 min 10 s, 3 min 00 s left"


def test_nothing_is_printed_where_a_program_shows_the_progress(capsys: pytest.CaptureFixture[str]) -> None:
    with show_progress(lambda what, done, total: None), count_progress("steps") as show:
        show(100, 100)
    assert capsys.readouterr().err == ""
