"""What a command costs from start to end, beside the imports that no flight can do without.

Run by hand: ``pytest -m slow -s tests/benchmarks/test_commands.py``.
"""

import os
import resource
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PEER = (sys.executable, "-c", "import numpy, numba, scipy")
BOUNDS = {
    "--help": 0.5,
    "plugins list": 1.5,
    "simulate RUN:TP1": 2.2,
    "inspect RUN:TP1": 2.3,
    "pick RUN 3.3 0 0.2": 2.3,
    "report RUN": 3.3,
}
"""Greatest CPU times of commands, in those of the imports."""

PROGRAM = str(Path(sys.executable).with_name("driftform"))


def measure_cpu(*arguments):
    """CPU time of a process and of its workers, from start to end, s."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(arguments, check=True, capture_output=True, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def test_commands_take_little_more_than_their_imports(count_of, tmp_path):
    run, again, repeats = tmp_path / "run", tmp_path / "again", count_of("REPEATS", 5)
    evolve = ("evolve", "--seed", "1", "--simulator", "native", "--workers", "2")
    commands = {
        "--help": ("--help",),
        "plugins list": ("plugins", "list"),
        "simulate RUN:TP1": ("simulate", f"{run}:TP1"),
        "inspect RUN:TP1": ("inspect", f"{run}:TP1"),
        "pick RUN 3.3 0 0.2": ("pick", str(run), "3.3", "0", "0.2"),
        "report RUN": ("report", str(run)),
        "evolve --simulator native": (*evolve, "--out", str(again)),
    }
    measure_cpu(PROGRAM, *evolve, "--out", str(run))
    lines = ["| command | CPU s | of the imports | at most |", "|---|---|---|---|"]
    ratios = {}
    for name, arguments in commands.items():
        # The first run compiles what is not cached yet.
        pairs = []
        for _ in range(repeats + 1):
            shutil.rmtree(again, ignore_errors=True)
            pairs.append((measure_cpu(PROGRAM, *arguments), measure_cpu(*PEER)))
        seconds = [own for own, _ in pairs[1:]]
        ratios[name] = statistics.median(own / peer for own, peer in pairs[1:])
        lines.append(f"| `{name}` | {statistics.median(seconds):.2f} | {ratios[name]:.2f} | {max(seconds):.2f} |")
    lines += [
        "",
        f"Medians of {repeats} runs with cached kernels, of a run of the default study: 500 flights, and the disturbed ones. "
        'Workers are included. The imports are `python -c "import numpy, numba, scipy"`, measured in turn with the command.',
    ]
    print("", *lines, sep="\n")
    assert {name: ratio for name, ratio in ratios.items() if ratio > BOUNDS.get(name, ratio)} == {}
