"""What studies and benchmarks share: their tables, on the screen and in docs/validation.md."""

import os
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "validation.md"


@pytest.fixture
def publish() -> Callable[[str, Sequence[str]], None]:
    """Show lines of Markdown; with UPDATE_DOCS=1 put them between the markers of their title, too."""

    def published(title: str, lines: Sequence[str]) -> None:
        print("\n" + "\n".join(lines))
        if os.environ.get("UPDATE_DOCS") != "1":
            return
        begin, end = f"<!-- {title} -->", f"<!-- end of {title} -->"
        head, found, rest = PAGE.read_text(encoding="utf-8").partition(begin)
        _, closed, tail = rest.partition(end)
        assert found and closed, f"{PAGE.name} has no place for '{title}'"
        PAGE.write_text(head + "\n".join([begin, "", *lines, "", end]) + tail, encoding="utf-8")

    return published


@pytest.fixture
def count_of() -> Callable[[str, int], int]:
    """How many of something to take: what the environment says (``AGENTS=20 pytest ...``), or what the page tells."""
    return lambda name, usual: int(os.environ.get(name, usual))


@pytest.fixture
def milliseconds() -> Callable[..., list[float]]:
    """The time of one call with each of the arguments, the best of three, ms."""

    def timed(function: Callable[[Any], Any], arguments: Iterable[Any]) -> list[float]:
        times = []
        for argument in arguments:
            calls = []
            for _ in range(3):
                start = time.perf_counter()
                function(argument)
                calls.append(1e3 * (time.perf_counter() - start))
            times.append(min(calls))
        return times

    return timed
