"""Evaluates random genomes in one process, and prints by how many MB it grows: ``resident.py SIMULATOR COUNT``."""

import os
import sys
from pathlib import Path

import numpy as np

from driftform.search.jobs import Job
from driftform.search.local import InProcess
from driftform.study import load_study

WARM_UP = 200


def resident() -> int:
    """Memory of this process that is in RAM, bytes."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGESIZE")


def main(use: str, count: int) -> None:
    """Print megabytes after the warm-up, and how many more there are in the end and at most."""
    study = load_study("paper", use={"simulator": use}, run={"seed": 1})
    executor, grammar, rng = (InProcess(study.make_pipeline()), study.make_plugin("grammar"), np.random.default_rng(1))
    genomes = (grammar.random(rng) for _ in range(WARM_UP + count))
    first = most = now = 0
    for index, genome in enumerate(genomes):
        list(executor.evaluate([Job(index, genome)]))
        if index + 1 >= WARM_UP and index % 50 == 49:
            now = resident()
            first, most = first or now, max(most, now)
    print(first / 1e6, (now - first) / 1e6, (most - first) / 1e6)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
