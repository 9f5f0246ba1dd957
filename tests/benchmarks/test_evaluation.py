"""What screening saves: the errors of unchecked flights, and the time of a search.

Run by hand: ``pytest -m slow -s tests/benchmarks``. With ``UPDATE_DOCS=1`` the tables go into docs/validation.md.
"""

import time
from dataclasses import replace
from itertools import chain

import numpy as np
import pytest

from driftform.pipeline import MARGIN
from driftform.runs.store import Store
from driftform.search.jobs import Job
from driftform.search.local import InProcess
from driftform.search.loop import run_search
from driftform.study import load_study

pytestmark = pytest.mark.slow

SIMULATORS = ("native", "exudyn")


def test_errors_of_unchecked_flights(publish, count_of, tmp_path):
    count = count_of("EVALUATIONS", 2000)
    lines = [
        "| simulator | genomes | CPU time over checked | fitness off by, median % | 99 % | largest "
        "| flights too low by more than the margin, % | of those that matter, missed |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for use, number in zip(SIMULATORS, (count, count // 10), strict=True):
        study = load_study(
            "paper", use={"simulator": use, "strategy": "evolution"}, run={"seed": 1, "evaluations": number}
        )
        pipeline, rng = study.make_pipeline(), np.random.default_rng(1)
        search = Recorder(InProcess(pipeline))
        with Store.create(tmp_path / f"{use}.db", {}) as store:
            run_search(study, store, search)
        nowhere = (np.inf,) * len(study.scenario.targets)
        random = [Job(index, pipeline.grammar.random(rng), threshold=nowhere) for index in range(number)]
        for name, jobs in (("random", random), ("of a search by `evolution`", search.jobs)):
            genomes = [job.genome for job in jobs]
            started = time.process_time()
            unchecked = pipeline.evaluate(genomes, thresholds=[nowhere] * number)
            middle = time.process_time()
            checked = pipeline.evaluate(genomes)
            ratio = (middle - started) / (time.process_time() - middle)
            found, true = (np.array([e.fitness for e in some]) for some in (unchecked, checked))
            sound = [evaluation.failure is None for evaluation in checked]
            off = np.abs(found - true)[sound]
            low = 100 * np.mean((true - found > MARGIN).any(axis=1))
            thresholds = [job.threshold for job in jobs]
            matter = (true > np.array(thresholds)).any(axis=1)
            screened = [e.trajectory for e in pipeline.evaluate(genomes, thresholds=thresholds)]
            missed = np.count_nonzero(matter & [flight is not None and flight.error is None for flight in screened])
            lines.append(
                f"| {use} | {name} | {ratio:.2f} | {np.median(off):.2g} | {np.quantile(off, 0.99):.2g} "
                f"| {off.max():.2g} | {low:.2g} | {missed} of {matter.sum()} |"
            )
            assert missed <= 0.02 * matter.sum()
    lines += [
        "",
        f"{count} genomes, a tenth of them with Exudyn; ten targets. The search is repeated with all flights checked: "
        "one above its threshold for any target matters, and is missed if it would stay unchecked. "
        f"Margin: {MARGIN:g} %.",
    ]
    publish("unchecked flights", lines)


class Recorder:
    """An executor that keeps its jobs, in their order."""

    def __init__(self, executor):
        self._executor = executor
        self.jobs = []

    def evaluate(self, jobs):
        # A search adds jobs while others are evaluated: those of now are taken, and it calls again for the others.
        taken = list(jobs)
        jobs.clear()
        self.jobs += taken
        return self._executor.evaluate(taken)


def test_what_a_search_takes_for_an_evaluation(publish, count_of, tmp_path):
    count = count_of("EVALUATIONS", 1000)
    lines = [
        "| simulator | strategy | evaluations | checked % | ms CPU each | over the same, all checked |",
        "|---|---|---|---|---|---|",
    ]
    for use, number in zip(SIMULATORS, (count, count // 4), strict=True):
        for strategy in ("evolution", "random"):
            study = load_study(
                "paper", use={"simulator": use, "strategy": strategy}, run={"seed": 1, "evaluations": number}
            )
            executor = InProcess(study.make_pipeline())
            search = Recorder(executor)
            with Store.create(tmp_path / f"{use}-{strategy}.db", {}) as store:
                run_search(study, store, search)
            every = [replace(job, threshold=None) for job in search.jobs]
            times = []
            for jobs in (search.jobs, every):
                began = time.process_time()
                outcomes = list(chain.from_iterable(executor.evaluate(jobs)))
                times.append(1e3 * (time.process_time() - began) / number)
                if jobs is search.jobs:
                    flights = [evaluation.trajectory for _, evaluation in outcomes]
                    checked = 100 * np.mean([flight and flight.error is not None for flight in flights])
            ratio = times[0] / times[1]
            lines.append(f"| {use} | {strategy} | {number} | {checked:.0f} | {times[0]:.2f} | {ratio:.2f} |")
            assert ratio < 1
    lines += ["", "CPU time from genome to stored flight, in one process, of the genomes of a search."]
    publish("search", lines)
