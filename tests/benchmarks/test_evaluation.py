"""How long each stage of an evaluation takes, and how many evaluations a second two workers make.

Run by hand: ``pytest -m slow -s tests/benchmarks``. With ``UPDATE_DOCS=1`` the tables go into docs/validation.md.
"""

import os
import platform
import time
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np
import pytest

from driftform.agent import mass_properties
from driftform.motion.forces.model import flight_model
from driftform.pipeline import MARGIN
from driftform.runs.compression import encode
from driftform.runs.store import Store
from driftform.search.in_process import InProcess
from driftform.search.jobs import Job, Outcome
from driftform.search.local import LocalProcesses
from driftform.search.loop import run_search
from driftform.study import load_study

pytestmark = pytest.mark.slow

SIMULATORS = ("native", "exudyn")


@pytest.mark.parametrize("study", ["paper", "pipe-inspection"])
def test_stages_of_an_evaluation(study, count_of, milliseconds):
    pipelines = {use: load_study(study, use={"simulator": use}).make_pipeline() for use in SIMULATORS}
    pipeline, rng = pipelines["native"], np.random.default_rng(0)
    scenario = pipeline.scenario
    genomes = [pipeline.grammar.random(rng) for _ in range(count_of("AGENTS", 60))]
    morphologies = [pipeline.express(genome) for genome in genomes]
    bodies = [pipeline.builder.build(morphology) for morphology in morphologies]
    agents = [pipeline.make_agent(genome) for genome in genomes]
    flights = pipeline.fly(agents)
    stages = {
        "express": milliseconds(pipeline.express, genomes),
        "build": milliseconds(pipeline.builder.build, morphologies),
        "mass properties": milliseconds(mass_properties, bodies),
        "coefficients": milliseconds(lambda body: pipeline.hydrodynamics.coefficients(body, scenario.fluid), bodies),
        "flight model": milliseconds(lambda agent: flight_model(agent, scenario), agents),
        "screen (native)": milliseconds(
            lambda agent: pipeline.simulator.screen_batch([agent], [scenario], lambda *_: False), agents
        ),
        "simulate (native)": milliseconds(lambda agent: pipeline.fly([agent]), agents),
        "simulate (Exudyn)": milliseconds(lambda agent: pipelines["exudyn"].fly([agent]), agents),
        "score ten targets": milliseconds(
            lambda trajectory: pipeline.fitness.score(trajectory, scenario, agents[0]), flights
        ),
        "encode for the store": milliseconds(encode, flights),
    }
    simulation = np.median(stages["simulate (native)"])
    # A flight makes its model itself.
    part = ("flight model", "screen (native)", "simulate (native)", "simulate (Exudyn)")
    others = sum(np.median(times) for name, times in stages.items() if name not in part)
    lines = ["| stage | median ms | 90 % ms | of a native flight |", "|---|---|---|---|"]
    for name, times in stages.items():
        median, high = np.median(times), np.quantile(times, 0.9)
        lines.append(f"| {name} | {median:.3g} | {high:.3g} | {median / simulation:.3g} |")
    lines += [
        f"| all but the simulation | {others:.3g} | | {others / simulation:.3g} |",
        "",
        f"{len(genomes)} random agents, each the best of three. A flight includes its model. "
        f"Python {platform.python_version()}, {os.cpu_count()} cores.",
    ]
    print("", *lines, sep="\n")


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

    def __init__(self, executor: InProcess) -> None:
        self._executor = executor
        self.jobs: list[Job] = []

    def evaluate(self, jobs: deque[Job]) -> Iterable[Sequence[Outcome]]:
        # A search adds jobs while others are evaluated: those of now are taken, and it calls again for the others.
        taken = list(jobs)
        jobs.clear()
        self.jobs += taken
        return self._executor.evaluate(taken)


def test_evaluations_per_second_with_two_workers(count_of):
    count = count_of("EVALUATIONS", 5000)
    lines = [
        "| simulator | workers | start-up s | evaluations per second | over one process | failed |",
        "|---|---|---|---|---|---|",
    ]
    for use in SIMULATORS:
        study = load_study("paper", use={"simulator": use}, run={"seed": 1})
        grammar, rng = study.make_plugin("grammar"), np.random.default_rng(1)
        jobs = [Job(index, grammar.random(rng)) for index in range(count)]

        alone, few = InProcess(study.make_pipeline()), jobs[: max(20, count // 25)]
        list(alone.evaluate(few[:2]))
        start = time.perf_counter()
        list(alone.evaluate(few))
        one = len(few) / (time.perf_counter() - start)

        executor = LocalProcesses(study.document, 2)
        try:
            start = time.perf_counter()
            # So many that both workers are surely under way; they import, load their kernels, and fly.
            list(executor.evaluate(jobs[:16]))
            started = time.perf_counter() - start - 16 / (2 * one)
            start = time.perf_counter()
            outcomes = list(chain.from_iterable(executor.evaluate(jobs)))
            rate = count / (time.perf_counter() - start)
        finally:
            executor.close()
        assert sorted(index for index, _ in outcomes) == list(range(count))
        failed = sum(evaluation.failure is not None for _, evaluation in outcomes)
        lines.append(f"| {use} | 2 | {started:.2g} | {rate:.3g} | {rate / one:.2g} | {failed} |")
    lines += ["", f"{count} random genomes of the default study, from genome to ten fitnesses; start-up is extra."]
    print("", *lines, sep="\n")


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
