"""numba is an accelerator: its oldest and its newest version, and its own compiler, give flights of the same bits."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

FLIGHTS = """
import numpy as np

from driftform.study import load_study
from driftform.util.compiled import IS_PLAIN

print("own" if IS_PLAIN else "ours")
for name in ("paper", "pipe-inspection"):
    pipeline = load_study(name, use={"simulator": "native"}, run={"seed": 0}).make_pipeline()
    rng = np.random.default_rng(0)
    genomes = [pipeline.grammar.random(rng) for _ in range(20)]
    for evaluation in pipeline.evaluate(genomes, [None] * 20, [None] * 20):
        assert evaluation.failure is None, evaluation.failure
        print(*(float(fitness).hex() for fitness in evaluation.fitness))
"""


@pytest.mark.installs
@pytest.mark.skipif(sys.version_info >= (3, 12), reason="the oldest numba has wheels for Python 3.11 only")
def test_the_oldest_and_the_newest_numba_and_its_own_compiler_give_the_same_bits(
    dist, new_environment, outside, tmp_path
):
    needs = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    [oldest] = (found[1] for need in needs if (found := re.match(r"numba>=([\d.]+),<1$", need)))
    [wheel] = dist.glob("driftform-[0-9]*.whl")
    local = ("--find-links", dist, wheel)
    old = new_environment(*local, f"numba=={oldest}.*")
    # Another version of NumPy may round differently.
    numpy = "import numpy; print(f'numpy=={numpy.__version__}')"
    new = new_environment(*local, outside(old / "python", "-c", numpy, cwd=tmp_path).strip())
    folders = {("oldest", ""): old, ("newest", ""): new, ("newest", "plain"): new}
    running = {}
    for (version, compiler), programs in folders.items():
        changes = {"DRIFTFORM_COMPILER": compiler, "NUMBA_CACHE_DIR": str(tmp_path / version)}
        inherited = {k: v for k, v in os.environ.items() if k not in ("VIRTUAL_ENV", "PYTHONPATH")}
        running[version, compiler] = subprocess.Popen(
            [programs / "python", "-c", FLIGHTS],
            env=inherited | changes,
            stdout=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
        )
    printed = {key: process.communicate()[0].splitlines() for key, process in running.items()}
    assert [process.returncode for process in running.values()] == [0, 0, 0]
    used = [lines.pop(0) for lines in printed.values()]
    assert used == ["own", "ours", "own"]
    first, *others = printed.values()
    assert len(first) == 40
    assert all(other == first for other in others)
