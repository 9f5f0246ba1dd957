"""How time and memory grow with a network: commands on towns on a square grid, each in a process of its own.

By hand: ``pytest -m slow -s plugins/driftform-networks/tests/test_growth.py``, on a machine that does nothing else.
"""

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.slow

PIPES = (1_000, 5_000, 20_000, 50_000)

BODY = ("sphere:15mm", "--release", "R", "--walks", "2000", "--buoyancy-error", "0")
"""It is mixed and narrow: no flights, which serve all networks, are timed with it."""

COMMANDS = {
    "the first show": ("show",),
    "show": ("show",),
    "route": ("route", *BODY),
    "fleet": ("fleet", "--agent", *BODY, "--size", "3", "--buoyancy", "0"),
    "plan": ("plan", "--agent", *BODY, "--hours", "0", "--nets", "4"),
}


def write_town(path, pipes):
    """Write a square grid of streets of 100 m, fed at a corner; every seventh street is a main."""
    side = round((1 + math.sqrt(1 + 2 * pipes)) / 2)
    rng = np.random.default_rng(0)
    rows = [(x, y, x + 1, y) for x in range(side - 1) for y in range(side)]
    rows += [(x, y, x, y + 1) for x in range(side) for y in range(side - 1)]
    bore = [600 if (y if right > x else x) % 7 == 0 else 200 for x, y, right, _ in rows]
    demand = rng.uniform(0.5, 1.5, (side, side)) * 400 / side**2
    nodes = [(x, y) for x in range(side) for y in range(side)]
    sections = {
        "JUNCTIONS": [f"J{x}-{y} 0 {demand[x, y]:.6f}" for x, y in nodes],
        "RESERVOIRS": ["R 80"],
        "PIPES": [
            "P R J0-0 100 1000 120 0 Open",
            *(
                f"P{x}-{y}-{u}-{v} J{x}-{y} J{u}-{v} 100 {width} 120 0 Open"
                for (x, y, u, v), width in zip(rows, bore, strict=True)
            ),
        ],
        "OPTIONS": ["Units LPS", "Headloss H-W", "Accuracy 1e-5", "Trials 200"],
        "TIMES": ["Duration 0"],
        "COORDINATES": [f"J{x}-{y} {100 * x} {100 * y}" for x, y in nodes] + ["R -100 0"],
    }
    path.write_text("".join(f"[{name}]\n" + "\n".join(lines) + "\n" for name, lines in sections.items()))


def measure(file, words):
    """Processor time, s, and memory, bytes, of a command with its child processes."""
    program = Path(sys.executable).with_name("driftform")
    command = [program, "network", words[0], str(file), *words[1:], "--cache", str(file.parent)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, command
    return used.ru_utime + used.ru_stime, used.ru_maxrss * 1024


def test_time_grows_no_faster_than_n_log_n(tmp_path):
    print(f"\n| pipes | n log n | {' | '.join(COMMANDS)} | MB |")
    found = []
    # What is compiled once per machine is not timed.
    write_town(tmp_path / "small.inp", 50)
    for words in COMMANDS.values():
        measure(tmp_path / "small.inp", words)
    for pipes in PIPES:
        write_town(tmp_path / f"{pipes}.inp", pipes)
        found.append({name: measure(tmp_path / f"{pipes}.inp", words) for name, words in COMMANDS.items()})
        order = pipes * math.log(pipes) / (PIPES[1] * math.log(PIPES[1]))
        row = "".join(f" {time:.1f} |" for time, _ in found[-1].values())
        most = max(size for _, size in found[-1].values())
        print(f"| {pipes} | {order:.2f} |{row} {most / 1e6:.0f} |", flush=True)
    for name in ("show", "route", "fleet", "plan"):
        # What a command takes in the smallest town does not depend on the size: it starts Python.
        start, small, large = (found[row][name][0] for row in (0, 1, 3))
        assert large - start < 1.5 * order * max(0.0, small - start) + 1, name
