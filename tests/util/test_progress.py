"""How far long work is."""

import threading
import time
from contextlib import closing

import pytest

from driftform.util import progress
from driftform.util.progress import count_progress, print_regularly, show_progress, track_progress


def test_short_work_prints_nothing(capsys):
    assert list(track_progress("abc", 3, "letters")) == ["a", "b", "c"]
    assert capsys.readouterr().err == ""


def test_longer_work_prints_one_line_at_its_end(capsys):
    list(track_progress(range(12), 10, "numbers", delay=0.0))
    # More items than announced are accepted.
    assert capsys.readouterr().err == "12/12 numbers, 0 s\n"


def test_closing_the_iterator_closes_the_iterated_items():
    ended = []

    def ones():
        try:
            while True:
                yield 1
        finally:
            ended.append(True)

    with closing(track_progress(ones(), 10, "ones", delay=0.0)) as seen:
        assert next(seen) == 1
    assert ended == [True]


@pytest.mark.parametrize("seconds", [5, 60, 3600])
def test_lines_are_ten_seconds_apart_and_one_is_last(capsys, seconds):
    now, over = 0.0, threading.Event()

    def wait(_):
        nonlocal now
        if now + progress.LINE_EVERY_S > seconds:
            over.set()
            return True
        now += progress.LINE_EVERY_S
        return False

    with print_regularly(lambda: f"{now:g} s", wait):
        assert over.wait(60)
    lines = capsys.readouterr().err.splitlines()
    assert lines[:-1] == [f"{t} s" for t in range(10, seconds + 1, 10)]
    assert len(lines) <= 1 + seconds / 10


def test_failed_work_has_no_last_line(capsys):
    with pytest.raises(ValueError, match="no"), count_progress("steps") as show:
        show(1, 2)
        raise ValueError("no")
    assert capsys.readouterr().err == ""


def test_the_time_left_is_that_of_the_steps_after_the_first(monkeypatch):
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


def test_nothing_is_printed_where_a_program_shows_the_progress(capsys):
    with show_progress(lambda what, done, total: None), count_progress("steps") as show:
        show(100, 100)
    assert capsys.readouterr().err == ""
