"""What the kernels cost a process that flies its first agents: compiled, and loaded from the cache."""

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow

FLIGHTS = """
import time

import numba
import numpy as np

from driftform.study import load_study

study = load_study("SCENARIO", settings=['flow.kind="KIND"'], use={"simulator": "native"}, run={"seed": 0})
pipeline, rng = study.make_pipeline(), np.random.default_rng(0)
genomes = [pipeline.grammar.random(rng) for _ in range(3)]
began = time.process_time()
for evaluation in pipeline.evaluate(genomes, [None] * 3, [None] * 3):
    assert evaluation.failure is None, evaluation.failure
print(time.process_time() - began)
"""


ROWS = {
    "`paper`, in the vertical plane": ("paper", "uniform"),
    "`paper`, in space": ("paper", "turbulent"),
    "`pipe-inspection`, in the vertical plane": ("pipe-inspection", "log_law"),
}


def flown(scenario, kind, cache):
    """CPU time of the first three evaluations of a process, s."""
    done = subprocess.run(
        [sys.executable, "-c", FLIGHTS.replace("SCENARIO", scenario).replace("KIND", kind)],
        env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout), done.stderr


def test_what_the_kernels_cost_a_process(tmp_path):
    lines = ["| flights | compiled, CPU s | loaded, CPU s | files |", "|---|---|---|---|"]
    for number, (flights, (scenario, kind)) in enumerate(ROWS.items()):
        cache = tmp_path / str(number)
        cold, said = flown(scenario, kind, cache)
        assert said.count("compiling the equations of motion") == 1
        warm, said = min(flown(scenario, kind, cache) for _ in range(3))
        assert "compiling" not in said
        files = len(list(cache.rglob("*.nbc")))
        lines.append(f"| {flights} | {cold:.2g} | {warm:.2g} | {files} |")
        assert warm < cold / 10
    lines += ["", "CPU time of the first three evaluations of a process, with an empty cache and with a full one."]
    print("", *lines, sep="\n")
