"""Does a process that evaluates for hours keep its size?"""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="resident memory is read from /proc"),
]

MEGABYTES = 20.0


def test_a_process_does_not_grow_with_what_it_evaluates(count_of):
    program = Path(__file__).with_name("resident.py")
    lines = ["| simulator | evaluations | MB after 200 | more in the end | more at most |", "|---|---|---|---|---|"]
    grown = {}
    count = count_of("EVALUATIONS", 10_000)
    for use in ("native", "exudyn"):
        done = subprocess.run([sys.executable, program, use, str(count)], stdout=subprocess.PIPE, text=True, check=True)
        first, more, grown[use] = map(float, done.stdout.split())
        lines.append(f"| {use} | {count} | {first:.0f} | {more:.1f} | {grown[use]:.1f} |")
    print("", *lines, sep="\n")
    assert max(grown.values()) < MEGABYTES, grown
