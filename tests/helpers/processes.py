"""What tests of running programs share: waiting, whether a process lives, and how far a run is."""

import time
from pathlib import Path

from driftform.errors import InputError
from driftform.runs.monitor import RunMonitor


def make_arguments(evaluations):
    """Return the arguments of a run for two targets with the fake simulator."""
    targets = ("--target", "TP1", "--target", "TP8")
    return ("paper", *targets, "--evaluations", evaluations, "--seed", 5, "--simulator", "fake")


def wait_until(condition, seconds=600.0):
    """Wait for a condition; fail if it does not hold in time."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.02)


def is_alive(process):
    """Return whether a process runs, by ``/proc``."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def look(directory):
    """Read a run once."""
    monitor = RunMonitor(directory)
    monitor.poll()
    return monitor


def count_evaluations(directory):
    """Return how many evaluations a run holds; 0 while it has not begun."""
    try:
        return look(directory).status.done
    except InputError:
        return 0
