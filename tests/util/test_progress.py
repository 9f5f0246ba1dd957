"""How far long work is."""

from collections.abc import Iterator
from contextlib import closing

import pytest

from driftform.util.progress import track_progress


def test_short_work_prints_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert list(track_progress("abc", 3, "letters")) == ["a", "b", "c"]
    assert capsys.readouterr().err == ""


def test_longer_work_prints_its_progress(capsys: pytest.CaptureFixture[str]) -> None:
    assert len(list(track_progress(range(50), 50, "numbers", delay=0.0))) == 50
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 10
    assert lines[-1] == "50/50 numbers"


def test_more_items_than_announced_are_accepted(capsys: pytest.CaptureFixture[str]) -> None:
    list(track_progress(range(12), 10, "numbers", delay=0.0))
    assert capsys.readouterr().err.splitlines()[-1] == "12/12 numbers"


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
