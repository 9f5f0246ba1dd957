"""How many processes this machine lets a program keep busy."""

import math
import os
from contextlib import suppress
from pathlib import Path

_GROUPS, _MEMBERSHIP = Path("/sys/fs/cgroup"), Path("/proc/self/cgroup")


def count_cores() -> int:
    """Return the number of processors that this process may use, by affinity and the quotas of its control groups (version 2)."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    group = _GROUPS
    with suppress(OSError):
        group /= _MEMBERSHIP.read_text().strip().rpartition("::/")[2]
    for folder in (group, *group.parents):
        # Without a limit the quota is "max"; outside of Linux there are no such files.
        with suppress(OSError, ValueError):
            quota, period = map(int, (folder / "cpu.max").read_text().split())
            cores = min(cores, max(1, math.ceil(quota / period)))
    return cores
