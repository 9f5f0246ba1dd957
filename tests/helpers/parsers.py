"""Functions that behave as the parsers of others do: called in a process of its own, which imports this module."""

import os
import sys
import time
from pathlib import Path

import numpy as np

from driftform.errors import InputError, WorkFailedError


def give_back(*values):
    return values


def give_code():
    return give_back


def loop():
    while True:
        pass


def sleep():
    time.sleep(600)


def take_memory():
    return sum(np.ones(1 << 27).nbytes for _ in range(64))


def crash():
    os.abort()


def leave():
    print("no licence")
    sys.exit(3)


def fail(kind, text):
    kinds = {
        "input": InputError,
        "work": WorkFailedError,
        "value": ValueError,
        "module": ModuleNotFoundError,
        "key": KeyError,
        "file": FileNotFoundError,
    }
    raise kinds[kind](text)


def leave_files():
    Path("scratch").write_text("x", encoding="utf-8")
    return str(Path.cwd())
