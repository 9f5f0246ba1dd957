"""What tests of running programs share: waiting, whether a process lives, and how far a run is."""

import os
import subprocess
import sys
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


class Clock:
    """A clock that goes when it is told to."""

    def __init__(self):
        self.now = 1000.0

    def __call__(self):
        return self.now


def start_on_terminal(*words, width, cwd=None, **variables):
    """Start the program on a terminal of 24 lines; return the process, and what is read from for what is shown."""
    import pty

    ours, theirs = pty.openpty()
    command = [sys.executable, "-c", "from driftform.cli import main; main()", *words]
    shape = {"COLUMNS": str(width), "LINES": "24", "TERM": "xterm"}
    process = subprocess.Popen(
        command, cwd=cwd, env=os.environ | shape | variables, stdin=theirs, stdout=theirs, stderr=theirs
    )
    os.close(theirs)
    return process, ours


def read_until(terminal, condition, seconds=600.0):
    """What a terminal shows until a condition holds, or nobody writes to it any more."""
    os.set_blocking(terminal, False)
    text, end = "", time.monotonic() + seconds
    while not condition(text):
        assert time.monotonic() < end, f"it did not happen in time: {text[-2000:]}"
        try:
            text += os.read(terminal, 65536).decode("utf-8", "replace")
        except BlockingIOError:
            time.sleep(0.02)
        except OSError:
            return text
    return text
