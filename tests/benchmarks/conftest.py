"""What studies and benchmarks share: how many to take, and how long it takes."""

import os
import time
from collections.abc import Callable, Iterable
from typing import Any

import pytest


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
