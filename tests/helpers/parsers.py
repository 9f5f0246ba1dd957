"""Functions that behave as the parsers of others do: called in a process of its own, which imports this module."""

import os
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from driftform.errors import InputError, WorkFailedError


def give_back(*values: Any) -> Any:
    return values


def give_code() -> Any:
    return give_back


def loop() -> None:
    while True:
        pass


def sleep() -> None:
    time.sleep(600)


def take_memory() -> int:
    return sum(np.ones(1 << 27).nbytes for _ in range(64))


def crash() -> None:
    os.abort()


def leave() -> None:
    print("no licence")
    sys.exit(3)


def fail(kind: str, text: str) -> None:
    kinds: dict[str, type[Exception]] = {
        "input": InputError,
        "work": WorkFailedError,
        "value": ValueError,
        "module": ModuleNotFoundError,
        "key": KeyError,
        "file": FileNotFoundError,
    }
    raise kinds[kind](text)


def leave_files() -> str:
    Path("scratch").write_text("x", encoding="utf-8")
    return str(Path.cwd())
