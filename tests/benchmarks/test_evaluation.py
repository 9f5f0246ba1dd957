"""How long each stage of an evaluation takes, and how many evaluations a second two workers make.

Run by hand: ``pytest -m slow -s tests/benchmarks``. With ``UPDATE_DOCS=1`` the tables go into docs/validation.md.
"""

import os
import platform
import time
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from driftform.dynamics.equations import accelerations
from driftform.dynamics.flight import has_left
from driftform.dynamics.model import flight_model
from driftform.dynamics.rotations import matrix_from_rotation_vector
from driftform.execution import LocalProcesses
from driftform.geometry import mass_properties
from driftform.study import load_study
from driftform.types import Evaluation

pytestmark = pytest.mark.slow

PAGE = Path(__file__).parents[2] / "docs" / "validation.md"
AGENTS = 60


def milliseconds(function, arguments):
    """Median and 90th percentile of the time of one call, ms."""
    times = []
    for argument in arguments:
        start = time.perf_counter()
        function(argument)
        times.append(1e3 * (time.perf_counter() - start))
    return float(np.median(times)), float(np.quantile(times, 0.9))


def reference_flight(agent, scenario):
    """The same equations by scipy's DOP853, the peer: rotation vector rates by the inverse tangent map."""
    model = flight_model(agent, scenario)
    out = np.empty(6)

    def rate(_, y):
        accelerations(y[:6], y[6:], model.table, model.rims, model.pipe, out)
        v, w = y[3:6], y[9:]
        theta = np.linalg.norm(v)
        half = theta / 2
        factor = 1 / 12 if theta < 1e-4 else (1 - half / np.tan(half)) / theta**2
        cross = np.cross(v, w)
        return np.concatenate([y[6:9], w + cross / 2 + factor * np.cross(v, cross), out])

    def outlet(_, y):
        return -1.0 if has_left(y[:3], model.pipe) else 1.0

    outlet.terminal = True
    start = np.concatenate([scenario.release.position, np.zeros(3), scenario.release_velocity(), np.zeros(3)])
    return solve_ivp(
        rate,
        (0, scenario.flight.horizon),
        start,
        "DOP853",
        rtol=1e-6,
        atol=1e-6,
        events=outlet,
        max_step=0.02,
    )


def update(title, lines):
    """Put the lines into the page between the title's markers."""
    print("\n" + "\n".join(lines))
    if not os.environ.get("UPDATE_DOCS"):
        return
    begin, end = f"<!-- {title} -->", f"<!-- end of {title} -->"
    head, _, rest = PAGE.read_text(encoding="utf-8").partition(begin)
    tail = rest.partition(end)[2]
    PAGE.write_text(head + "\n".join([begin, *lines, end]) + tail, encoding="utf-8")


def test_stages_of_an_evaluation():
    pipeline = load_study("pipe-inspection").pipeline()
    scenario = pipeline.scenario
    rng = np.random.default_rng(0)
    genomes = [pipeline.grammar.random(rng) for _ in range(AGENTS)]
    morphologies = [pipeline.express(genome) for genome in genomes]
    bodies = [pipeline.builder.build(morphology) for morphology in morphologies]
    agents = [pipeline.agent(genome) for genome in genomes]
    flights = pipeline.fly(agents)
    stages = {
        "express": milliseconds(pipeline.express, genomes),
        "build": milliseconds(pipeline.builder.build, morphologies),
        "mass properties": milliseconds(mass_properties, bodies),
        "coefficients": milliseconds(
            lambda body: pipeline.hydrodynamics.coefficients(body, scenario.fluid), bodies
        ),
        "simulate (Exudyn)": milliseconds(lambda agent: pipeline.fly([agent]), agents),
        "score ten targets": milliseconds(lambda flight: pipeline.fitness.score(flight, scenario), flights),
    }
    peer = milliseconds(lambda agent: reference_flight(agent, scenario), agents[:15])
    lines = ["", "| stage | median ms | 90 % ms |", "|---|---|---|"]
    lines += [f"| {name} | {median:.3g} | {high:.3g} |" for name, (median, high) in stages.items()]
    total = sum(median for median, _ in stages.values())
    ratio = peer[0] / stages["simulate (Exudyn)"][0]
    lines += [
        f"| sum of medians | {total:.3g} | |",
        "",
        f"The same right-hand side under SciPy's DOP853 at the same tolerance takes {peer[0]:.3g} ms (median of 15), "
        f"{ratio:.2g} times as long as Exudyn. {AGENTS} random agents, Python {platform.python_version()}, "
        f"{os.cpu_count()} cores.",
        "",
    ]
    update("stages", lines)
    assert ratio > 1


def test_evaluations_per_second_with_two_workers():
    study = load_study("pipe-inspection")
    grammar = study.plugin("grammar")
    rng = np.random.default_rng(1)
    jobs = [(index, grammar.random(rng)) for index in range(400)]
    rates = {}
    for workers in (1, 2):
        executor = LocalProcesses(study.document, workers)
        try:
            list(
                executor.evaluate([(-1, grammar.random(rng)) for _ in range(4 * workers)])
            )  # warm: import, compile
            start = time.perf_counter()
            outcomes: list[tuple[int, Evaluation]] = list(executor.evaluate(jobs))
            rates[workers] = len(jobs) / (time.perf_counter() - start)
        finally:
            executor.close()
        assert sorted(index for index, _ in outcomes) == list(range(len(jobs)))
    lines = ["", "| workers | evaluations per second |", "|---|---|"]
    lines += [f"| {workers} | {rate:.0f} |" for workers, rate in rates.items()]
    update("rate", [*lines, ""])
    assert rates[2] > rates[1]


def test_the_reference_flight_agrees_with_exudyn_before_it_is_called_a_peer():
    pipeline = load_study("pipe-inspection", ["flight.horizon=0.5"]).pipeline()
    agent = pipeline.agent(pipeline.grammar.random(np.random.default_rng(3)))
    [flight] = pipeline.fly([agent])
    solution = reference_flight(agent, pipeline.scenario)
    R = np.empty((3, 3))
    matrix_from_rotation_vector(solution.y[3:6, -1], R)
    assert np.isfinite(R).all()
    assert solution.y[:3, -1] == pytest.approx(flight.position[-1], abs=1e-3)
