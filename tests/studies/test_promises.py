"""Do flights keep what a run promises, and does the survey find agents as good with fewer flights?

``UPDATE_DOCS=1 pytest -m slow -s tests/studies/test_promises.py`` writes the tables of docs/results.md; ``SEEDS=2`` takes
fewer runs.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from math import inf
from pathlib import Path

import numpy as np
import pytest

from driftform.motion.approach import closest_approach
from driftform.motion.drag_coefficients import CROSSFLOW_PLATEAU
from driftform.motion.way import find_offsets
from driftform.runs.misses import PROMISED, estimate_quantile
from driftform.runs.store import Store
from driftform.search.finalists import find_winner, fly_finalists
from driftform.search.jobs import Executor, Job
from driftform.search.local import LocalProcesses
from driftform.search.loop import run_search
from driftform.study import Study, load_study
from driftform.types import FloatArray
from driftform.water import Scenario
from driftform.water.disturbances import disturb_body, draw_conditions
from driftform.water.flow import KARMAN
from driftform.water.gusts import eddy_diffusivity

pytestmark = pytest.mark.slow

SEEDS = 10
FRESH = 200
"""Flights of each printed agent under conditions that its run never saw."""

NOMINAL = "nominal search, then judged"
SURVEY = "search with a survey (default)"
WAYS = {
    SURVEY: ("robustness.survey=2", "robustness.finalists=4"),
    # As many flights: the search of the other takes three for each agent that matters.
    NOMINAL: ("robustness.survey=0", "robustness.finalists=7"),
}
EVALUATIONS = {SURVEY: 440, NOMINAL: 560}
"""So that a run has 1500 flights before the promise."""


@dataclass(frozen=True)
class Outcome:
    """A run: its flights before the promise, the promises, and the misses of fresh flights, m, (targets, flights)."""

    flights: int
    promised: FloatArray
    nominal: FloatArray
    fresh: FloatArray


def study_of(way: str, seed: int) -> Study:
    run = {"seed": seed, "evaluations": EVALUATIONS[way]}
    return load_study("pipe-inspection", WAYS[way], use={"simulator": "native"}, run=run)


@pytest.fixture(scope="module")
def executor() -> Iterator[Executor]:
    with closing(LocalProcesses(study_of(SURVEY, 1).document, 2)) as executor:
        yield executor


def run_and_verify(way: str, seed: int, executor: Executor, folder: Path) -> Outcome:
    study = study_of(way, seed)
    targets, points = study.scenario.target_names, study.scenario.target_array()
    with Store.create(folder / f"{len(way)}-{seed}.db", dict(study.document)) as store:
        run_search(study, store, executor)
        fly_finalists(study, store, executor)
        winners = [find_winner(study, store, target) for target in targets]
        indices = [winner.index for winner in winners if winner is not None]
        promised = [w.misses.promised[0] for w in winners if w is not None and w.misses is not None]
        records = [store.read_record(index, targets) for index in indices]
        checks = study.scenario.robustness.checks
        flights = store.count() + len(store.list_disturbed()) - checks * len(set(indices))
    conditions = draw_conditions(study.scenario.robustness, FRESH, (seed, 1000))
    jobs = [
        Job(
            number,
            records[number // FRESH].candidate.genome,
            None,
            conditions[number % FRESH],
            (inf,) * len(targets),
        )
        for number in range(len(targets) * FRESH)
    ]
    misses = np.full(len(jobs), np.inf)
    for arrived in executor.evaluate(jobs):
        for number, evaluation in arrived:
            if evaluation.failure is None:
                misses[number] = np.linalg.norm(find_offsets(evaluation, study.scenario)[number // FRESH])
    nominal = [
        np.inf
        if record.evaluation.trajectory is None
        else closest_approach(record.evaluation.trajectory, points)[0][n]
        for n, record in enumerate(records)
    ]
    return Outcome(flights, np.array(promised), np.array(nominal), misses.reshape(len(targets), FRESH))


@pytest.fixture(scope="module")
def outcomes(executor: Executor, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Outcome]]:
    folder = tmp_path_factory.mktemp("promises")
    seeds = range(1, int(os.environ.get("SEEDS", SEEDS)) + 1)
    found: dict[str, list[Outcome]] = {way: [] for way in WAYS}
    for seed in seeds:
        for way in WAYS:
            found[way].append(run_and_verify(way, seed, executor, folder))
            p90 = estimate_quantile(found[way][-1].fresh.T, PROMISED)
            print(f"{way}, seed {seed}: {np.median(p90):.3f} m, {found[way][-1].flights} flights", flush=True)
    return found


def kept_of(outcomes: Sequence[Outcome]) -> FloatArray:
    """Share of the fresh flights within the promise, for each target, over all runs."""
    return np.mean([(o.fresh <= o.promised[:, None]).mean(axis=1) for o in outcomes], axis=0)


def reached(outcomes: Sequence[Outcome]) -> FloatArray:
    """Miss that 9 of 10 fresh flights stay within, m, (runs, targets)."""
    return np.array([estimate_quantile(o.fresh.T, PROMISED) for o in outcomes])


def axis_speed(scenario: Scenario) -> float:
    """Speed of the water on the axis, m/s: U + 3 u* / (2 kappa) of the logarithmic law."""
    return float(scenario.flow.speed + 1.5 * scenario.friction_velocity() / KARMAN)


def tracer_floor(study: Study) -> FloatArray:
    """90 % miss, m, (targets,), of a point that the mean flow carries exactly through each target, by gusts alone.

    A point that moves with the water is displaced across the mean flow by the integral of an Ornstein-Uhlenbeck process
    of standard deviation s and integral time T: 2 s^2 T^2 (t / T - 1 + exp(-t / T)) along each axis (Taylor 1922,
    Diffusion by continuous movements). The distance in the plane across the flow is then Rayleigh distributed. The time is
    that of water on the axis, the shortest; s and T are those of the core of the pipe.
    """
    scenario = study.scenario
    radius, s = scenario.pipe.segments[0].radius, scenario.gusts.strength * scenario.friction_velocity()
    memory = scenario.gusts.memory * eddy_diffusivity(radius, radius) * scenario.friction_velocity() / s**2
    t = scenario.target_array()[:, 0] / axis_speed(scenario) / memory
    deviation = s * memory * np.sqrt(2 * (t - 1 + np.exp(-t)))
    return np.asarray(deviation * np.sqrt(-2 * np.log(1 - PROMISED)))


def weight_floor(study: Study) -> FloatArray:
    """90 % miss, m, (targets,), of a body that rises or sinks to each target at its terminal speed, by its weight alone.

    The weight of a hull varies with its surface, at least twice the area that it shows to the water: that of a thin plate. The
    drag that resists goes with this area: rho C w |w| / 2 = g dm for each area, with C = 1.18, the greatest of the model (a
    disc has 1.17). So no shape does better, except along a wall. A body that neither rises nor sinks has the speed of the
    whole error. The time is that of water on the axis, the shortest.
    """
    scenario, robustness = study.scenario, study.scenario.robustness
    pipeline = study.make_pipeline()
    body = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(0))).body
    densities = [disturb_body(c, body).hull_density for c in draw_conditions(robustness, 20_000, (0,))]
    heavier = 2 * body.wall * (np.array(densities) - body.hull_density)
    x, _, z = scenario.target_array().T
    time = x / axis_speed(scenario)
    rise = z / time
    square = rise * np.abs(rise) - 2 * scenario.fluid.gravity * heavier[:, None] / (
        scenario.fluid.density * CROSSFLOW_PLATEAU
    )
    missed = np.abs(np.sign(square) * np.sqrt(np.abs(square)) - rise) * time
    return np.asarray(np.quantile(missed, PROMISED, axis=0))


def test_flights_keep_what_a_run_promises(
    outcomes: dict[str, list[Outcome]], publish: Callable[[str, Sequence[str]], None]
) -> None:
    runs = outcomes[SURVEY]
    kept = kept_of(runs)
    study = study_of(SURVEY, 1)
    lines = [
        f"{len(runs)} runs with `native` flights; {FRESH} fresh disturbed flights of each printed agent. Lengths in mm, medians over runs.",
        "",
        "| target | nominal | 90 % promised | 90 % of fresh flights | flights that keep the promise | gusts alone | weight alone | both |",
        "|---|---|---|---|---|---|---|---|",
    ]
    medians = [
        1000 * np.median(values, axis=0)
        for values in ([o.nominal for o in runs], [o.promised for o in runs], reached(runs))
    ]
    floor, weight = 1000 * tracer_floor(study), 1000 * weight_floor(study)
    for number, name in enumerate(study.scenario.target_names):
        cells = [f"{column[number]:.0f}" for column in medians]
        lines.append(
            f"| {name} | {' | '.join(cells)} | {100 * kept[number]:.0f} % | {floor[number]:.0f} | {weight[number]:.0f} | {np.hypot(floor[number], weight[number]):.0f} |"
        )
    lines.append(f"| all | | | | {100 * kept.mean():.1f} % | | | |")
    publish("promises", lines)
    assert 0.85 <= kept.mean() <= 0.95
    assert ((kept >= 0.85) & (kept <= 0.95)).sum() >= 8


def test_a_search_with_a_survey_finds_better_agents_with_as_many_flights(
    outcomes: dict[str, list[Outcome]], publish: Callable[[str, Sequence[str]], None]
) -> None:
    lines = [
        "| search | flights before the promise | 90 % miss: mean over targets, mm | median over targets, mm |",
        "|---|---|---|---|",
    ]
    for way, runs in outcomes.items():
        p90 = 1000 * reached(runs)
        flights = np.mean([o.flights for o in runs])
        lines.append(f"| {way} | {flights:.0f} | {p90.mean():.0f} | {np.median(p90, axis=1).mean():.0f} |")
    publish("ways to search", lines)
    flights = {way: np.mean([o.flights for o in runs]) for way, runs in outcomes.items()}
    assert flights[SURVEY] < 1.05 * flights[NOMINAL]
    assert reached(outcomes[SURVEY]).mean() < reached(outcomes[NOMINAL]).mean()
