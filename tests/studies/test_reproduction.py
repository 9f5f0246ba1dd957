"""The paper's experiment from end to end, with both simulators, as docs/results.md tells of it.

``UPDATE_DOCS=1 pytest -m slow -s tests/studies/test_reproduction.py`` writes the page and its pictures anew.
"""

import json
import os
import resource
import shutil
from pathlib import Path

import pytest

from driftform.search.baseline import HALVINGS, SPEEDS, tune_baselines
from driftform.search.local import InProcess
from driftform.study import load_study

pytestmark = pytest.mark.slow

DOCS = Path(__file__).parents[2] / "docs"
REPEATS = {"native": 10, "exudyn": 1}
"""Exudyn integrates a rigid body step by step: all ten repeats take it an hour and a half."""

WITHIN = {"native": 200.0, "exudyn": 1800.0}
"""Seconds of CPU time; the paper took 20 hours for half as many flights as ten repeats."""


def cpu_of_children():
    """CPU time of the processes that have ended, s: other work on the machine does not count."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@pytest.mark.parametrize("simulator", ["native", "exudyn"])
def test_the_experiment_is_repeated_and_told(simulator, start, publish, tmp_path):
    out = tmp_path / "out"
    before = cpu_of_children()
    repeats = REPEATS[simulator]
    words = ("--simulator", simulator, "--repeats", repeats, "--workers", 2, "--out", out, "--json")
    process = start("reproduce", *words, cwd=tmp_path)
    printed, told = process.communicate(timeout=3600)
    seconds = cpu_of_children() - before
    assert process.returncode == 0, told
    document = json.loads(printed)
    # Flights that no tolerance makes sure of fail, and say so.
    assert max(document["failed"].values()) <= 0.01 * 500 * repeats
    print(f"\n{simulator}: {1000 * repeats} flights and the rest in {seconds:.0f} s of CPU time")
    if simulator == "native":
        publish("reproduction", Path(document["results"]).read_text().splitlines())
        if os.environ.get("UPDATE_DOCS") == "1":
            for path in map(Path, document["figures"]):
                if path.suffix == ".svg":
                    shutil.copy(path, DOCS / "images" / f"reproduction-{path.name}")
        publish("reproduction with native", [f"native: {seconds:.0f} s"])
    assert seconds <= WITHIN[simulator]


def test_a_sphere_that_is_tuned_passes_every_target_of_the_paper(publish):
    study = load_study("paper", ["builder.tuning=wall"])
    pipeline = study.make_pipeline()
    spheres = tune_baselines(study, InProcess(pipeline), range(10))
    flights = pipeline.evaluate([sphere.genome for sphere in spheres.values()])
    errors = [100 - float(flight.fitness[target]) for target, flight in zip(spheres, flights, strict=True)]
    kinds = {sphere.kind for sphere in spheres.values()}
    flown = len(SPEEDS) + 2 * HALVINGS
    text = (
        f"A {', '.join(kinds)} around the paper's core, whose wall is tuned with {flown} flights for each target, errs by "
        f"{sum(errors) / len(errors):.2f} % in the mean over the targets and by {max(errors):.2f} % at most."
    )
    publish("tuned sphere", [text])
    assert len(errors) == 10 and max(errors) < 1
