"""How far long work is."""

from collections.abc import Iterator
from contextlib import closing

import pytest

from driftform.util.progress import track_progress


def test_work_that_is_soon_done_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert list(track_progress("abc", 3, "letters")) == ["a", "b", "c"]
    assert capsys.readouterr().err == ""


def test_work_that_takes_longer_says_how_far_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert len(list(track_progress(range(50), 50, "numbers", patience=0.0))) == 50
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 10
    assert lines[-1] == "50/50 numbers"


def test_more_than_were_told_of_are_no_mistake(capsys: pytest.CaptureFixture[str]) -> None:
    list(track_progress(range(12), 10, "numbers", patience=0.0))
    assert capsys.readouterr().err.splitlines()[-1] == "12/12 numbers"


def test_whoever_stops_looking_ends_what_is_looked_at() -> None:
    ended = []

    def ones() -> Iterator[int]:
        try:
            while True:
                yield 1
        finally:
            ended.append(True)

    with closing(track_progress(ones(), 10, "ones", patience=0.0)) as seen:
        assert next(seen) == 1
    assert ended == [True]
