"""How the tests are spread over processes: the whole suite over all cores, and kernels compiled once, before them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

MOST_WORKERS = 8

KERNELS = """
import numpy as np

from driftform.study import load_study
from driftform.testing.textbook import distance_from_textbook, random_case

for simulator in ("native", "exudyn"):
    for name in ("pipe-inspection", "water-main"):
        pipeline = load_study(name, use={"simulator": simulator}, run={"seed": 0}).make_pipeline()
        genome = pipeline.grammar.random(np.random.default_rng(0))
        pipeline.simulator.simulate(pipeline.make_agent(genome), pipeline.scenario)
    agent, scenario = random_case(0, 0.1)
    distance_from_textbook(pipeline.simulator.simulate(agent, scenario), agent, scenario, 0.1)
"""


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Return a worker for each core, or 0 (one process) for single files, ``-m slow``, and tests that write pages."""
    folders = any(Path(name).is_dir() for name in config.args)
    default = config.option.markexpr in config.getini("addopts")
    if not folders or not default or os.environ.get("UPDATE_DOCS") == "1":
        return 0
    return min(MOST_WORKERS, os.cpu_count() or 1)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """Compile the kernels before the workers start, each of which would do so itself."""
    subprocess.run([sys.executable, "-c", KERNELS], check=True)
