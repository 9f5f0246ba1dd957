"""What the benchmarks share: how long something takes."""

import time
from collections.abc import Callable, Iterable
from typing import Any

import pytest


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
