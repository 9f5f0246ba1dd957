"""How long each stage of an evaluation takes, and how many evaluations a second two workers make.

Run by hand: ``pytest -m slow -s tests/benchmarks``. With ``UPDATE_DOCS=1`` the tables go into docs/validation.md.
"""

import os
import platform
import time
from itertools import chain

import numpy as np
import pytest

from driftform.dynamics.model import flight_model
from driftform.execution import InProcess, Job, LocalProcesses
from driftform.geometry import mass_properties
from driftform.study import load_study
from driftform.trajectory.compression import encode

pytestmark = pytest.mark.slow

SIMULATORS = ("native", "exudyn")


def test_stages_of_an_evaluation(publish, count_of, milliseconds):
    pipelines = {use: load_study(use={"simulator": use}).make_pipeline() for use in SIMULATORS}
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
        "coefficients": milliseconds(
            lambda body: pipeline.hydrodynamics.coefficients(body, scenario.fluid), bodies
        ),
        "flight model": milliseconds(lambda agent: flight_model(agent, scenario), agents),
        "simulate (native)": milliseconds(lambda agent: pipeline.fly([agent]), agents),
        "simulate (Exudyn)": milliseconds(lambda agent: pipelines["exudyn"].fly([agent]), agents),
        "score ten targets": milliseconds(
            lambda trajectory: pipeline.fitness.score(trajectory, scenario, agents[0]), flights
        ),
        "encode for the store": milliseconds(encode, flights),
    }
    simulation = np.median(stages["simulate (native)"])
    # A flight makes its model itself.
    part = ("flight model", "simulate (native)", "simulate (Exudyn)")
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
    publish("stages", lines)


def test_evaluations_per_second_with_two_workers(publish, count_of):
    count = count_of("EVALUATIONS", 5000)
    lines = [
        "| simulator | workers | start-up s | evaluations per second | over one process | failed |",
        "|---|---|---|---|---|---|",
    ]
    for use in SIMULATORS:
        study = load_study(use={"simulator": use}, run={"seed": 1})
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
    lines += [
        "",
        f"{count} random genomes of the default study, from genome to ten fitnesses; start-up is extra.",
    ]
    publish("rate", lines)
