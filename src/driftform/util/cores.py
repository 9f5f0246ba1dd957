"""How many processes this machine lets a program keep busy."""

import os


def count_cores() -> int:
    """Return the number of processors that this process may use: a batch system or ``taskset`` may allow less than all."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
