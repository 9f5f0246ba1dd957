"""The last round: who is flown again, and who wins."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.agent import mass_properties
from driftform.motion.path.targets import find_offsets
from driftform.runs.store import DisturbedResult, Store
from driftform.search import finalists
from driftform.search.disturbed import draw_rounds
from driftform.search.finalists import (
    ROUND,
    choose_finalists,
    find_best_agent,
    find_winner,
    fly_finalists,
    robust_fitness,
)
from driftform.search.local import InProcess
from driftform.search.loop import run_search
from driftform.study import load_study
from driftform.types import Evaluation
from driftform.water.disturbances import FLOWN, KNOWN, Condition, Specimen
from driftform.water.scenario import Robustness

SETTINGS = ("robustness.conditions=4", "robustness.finalists=2", "robustness.checks=3")

CALM = Condition()

BASELINES = set(range(16, 22))
"""Numbers of the flights of both baselines."""


def study_of(*settings, evaluations=8):
    return load_study(
        "paper",
        settings=(*SETTINGS, *settings),
        targets=["TP2", "TP6"],
        use={"simulator": "native", "strategy": "random"},
        run={"seed": 2, "evaluations": evaluations},
    )


@pytest.fixture
def store(tmp_path):
    study = study_of()
    with Store.create(tmp_path / "run.db", dict(study.document)) as store:
        run_search(study, store, InProcess(study.make_pipeline()))
        yield store


def test_finalists_fly_under_each_condition_of_the_choice_and_winners_under_those_of_the_promise(store):
    study, seen = study_of(), []
    executor = InProcess(study.make_pipeline())
    fly_finalists(study, store, executor, lambda done, total: seen.append((done, total)))
    fitness = np.array([brief.fitness for brief in store.read_summaries(("TP2", "TP6"))])
    finalists = {int(i) for column in fitness.T for i in np.argsort(-column)[:2]}
    winners = {won.index for t in ("TP2", "TP6") if (won := find_winner(study, store, t)) is not None}
    assert winners <= finalists
    for target in ("TP2", "TP6"):
        flown = {index: set(flights) for index, flights in store.read_disturbed(target).items()}
        assert flown.keys() == finalists
        assert all(flown[index] >= set(range(13)) for index in winners)
        # The baseline of the first target has the numbers 16 to 18, and that of the second those to 21.
        for numbers in flown.values():
            assert {n for n in numbers if n < 13} == set(range(len(numbers - BASELINES)))
    total = len(store.list_disturbed())
    assert total <= 4 * len(finalists) + 9 * len(winners) + len(BASELINES)
    assert seen[0][0] == 0 and seen[-1] == (total, total)
    assert all(a <= b for (a, _), (b, _) in pairwise(seen))
    assert all(total <= promised for _, promised in seen)
    again = []
    fly_finalists(study, store, executor, lambda done, total: again.append((done, total)))
    assert again[-1] == (total, total) and len(store.list_disturbed()) == total


def test_what_is_stored_is_what_the_pipeline_finds_under_that_condition(store):
    study = study_of()
    fly_finalists(study, store, InProcess(study.make_pipeline()))
    index, flights = next(iter(store.read_disturbed("TP6").items()))
    offsets = store.read_offsets("TP6", index)
    assert offsets.keys() == flights.keys()
    flights = {number: fitness for number, fitness in flights.items() if number not in BASELINES}
    genome = store.read_record(index, ("TP2", "TP6")).candidate.genome
    conditions = draw_rounds(study)
    # Flights of the choice are unchecked, and those of the promise are checked.
    unchecked = [(np.inf, np.inf)] * 4
    evaluations = study.make_pipeline().evaluate(
        [genome] * len(flights),
        conditions=conditions[: len(flights)],
        thresholds=[*unchecked, *[None] * 9][: len(flights)],
    )
    d_max = study.scenario.pipe.farthest_distance(study.scenario.targets["TP6"])
    for number, evaluation in enumerate(evaluations):
        fitness, offset = flights[number], offsets[number]
        assert fitness == float(evaluation.fitness[1])
        if evaluation.failure is not None:
            np.testing.assert_array_equal(offset, find_offsets(evaluation, study.scenario)[1])
            continue
        assert np.linalg.norm(offset) == pytest.approx((1 - fitness / 100) * d_max, abs=1e-5)


def test_flights_of_the_promise_say_nothing_of_targets_that_another_agent_is_for(tmp_path):
    study = study_of(evaluations=20)
    with Store.create(tmp_path / "run.db", dict(study.document)) as store:
        run_search(study, store, InProcess(study.make_pipeline()))
        fly_finalists(study, store, InProcess(study.make_pipeline()))
        winners = {target: find_winner(study, store, target) for target in ("TP2", "TP6")}
        first, second = (won.index for won in winners.values() if won is not None)
        assert first != second
        for target, (winner, other) in (("TP2", (first, second)), ("TP6", (second, first))):
            flown = store.read_disturbed(target)
            assert not np.isnan([flown[winner][number] for number in range(4, 13)]).any()
            assert np.isnan([flown[other][number] for number in range(4, 13)]).all()


def test_the_conditions_of_the_promise_are_not_those_of_the_choice():
    drawn = draw_rounds(study_of())
    assert len(set(drawn)) == len(drawn) == 4 + 3 * len(FLOWN)
    assert not {c.gusts for c in drawn[:4]} & {c.gusts for c in drawn[4:]}


def test_weighed_prints_fly_again_in_known_gusts_if_the_gusts_are_in_doubt(tmp_path):
    options = {"targets": ["TP2"], "use": {"simulator": "native", "strategy": "random"}}
    study = load_study("pipe-inspection", settings=SETTINGS, run={"seed": 2, "evaluations": 6}, **options)
    drawn = draw_rounds(study)
    assert len(drawn) == 4 + 3 * (len(FLOWN) + 1)
    assert drawn[-3:] == tuple(replace(c, turbulence=KNOWN) for c in drawn[7:10])
    sure = [f"robustness.gust_{name}=0" for name in ("strength", "memory", "crossing")]
    for table in (sure, ["robustness.gusts=false"], ["gusts.strength=0"]):
        calm = load_study("pipe-inspection", settings=(*SETTINGS, *table), **options)
        assert len(draw_rounds(calm)) == 4 + 3 * len(FLOWN)
    executor = InProcess(study.make_pipeline())
    with Store.create(tmp_path / "run.db", dict(study.document)) as store:
        run_search(study, store, executor)
        fly_finalists(study, store, executor)
        winner = find_winner(study, store, "TP2")
    assert winner is not None
    found = {specimen: promise.document() for specimen, promise in winner.promises.items()}
    assert [specimen for specimen in found if "p90_known_gusts" in found[specimen]] == [Specimen.WEIGHED]
    assert 0 < abs(found[Specimen.WEIGHED]["p90_known_gusts"] - found[Specimen.WEIGHED]["p90"]) < 0.1


def test_the_best_agent_is_the_one_that_was_chosen_with_its_own_promise(store):
    study = study_of()
    fly_finalists(study, store, InProcess(study.make_pipeline()))
    masses = weigh_prints(study, store)
    for number, target in enumerate(("TP2", "TP6")):
        disturbed = store.read_disturbed(target)
        scores = {
            i: robust_fitness(np.array([flights[c] for c in range(4)]), study.scenario.robustness)
            for i, flights in disturbed.items()
        }
        best = find_best_agent(study, store, target)
        assert best is not None
        chosen = best.result["evaluation"]
        assert chosen == find_lightest(scores, masses)
        assert best.result["robust"]["score"] == pytest.approx(scores[chosen])
        # A flight that failed misses by more than any other, and JSON has no infinite number.
        offsets = store.read_offsets(target, chosen)
        lengths = [np.linalg.norm(offsets[c]) for c in (4, 5, 6)]
        fresh = sorted(np.inf if np.isnan(length) else float(length) for length in lengths)
        for name, length in (("median", fresh[1]), ("p90", fresh[2])):
            assert best.result[name] == (None if np.isinf(length) else pytest.approx(length))
        record = store.read_record(chosen, ("TP2", "TP6"))
        assert best.result["fitness"] == record.evaluation.fitness[number]
        assert best.genome == record.candidate.genome


def weigh_prints(study, store):
    """Mass of each print without core and ballast, kg."""
    designs, pipeline = store.read_records(("TP2", "TP6")), study.make_pipeline()
    bodies = {record.index: pipeline.make_agent(record.candidate.genome).body for record in designs}
    return {
        i: mass_properties(body).mass - body.core.mass - body.ballast_density * body.ballast.volume
        for i, body in bodies.items()
    }


def find_lightest(scores, masses):
    """Of those that lack to 100 % at most a twentieth more than the best, the one with the lightest print."""
    lacks = {index: 100 - score for index, score in scores.items()}
    equal = [index for index in lacks if lacks[index] <= 1.05 * min(lacks.values())]
    return min(equal, key=lambda index: masses[index])


def scored(index, condition, fitness):
    return DisturbedResult(index, condition, np.array([fitness, 50.0]), np.ones((2, 3)))


def test_one_that_is_best_undisturbed_loses_to_one_that_can_be_relied_on(store):
    study = study_of("robustness.score='mean'")
    favourite = store.find_best("TP2")
    assert favourite is not None
    other = next(i for i in range(8) if i != favourite[0])
    flights = {other: [70.0] * 4, favourite[0]: [99.0, 99.0, 10.0, 10.0]}
    store.add([], ("TP2", "TP6"), [scored(index, c, at[c]) for index, at in flights.items() for c in range(4)])
    found = find_winner(study, store, "TP2")
    assert found is not None
    assert (found.index, found.score) == (other, 70.0)
    greedy = find_winner(study_of("robustness.score='quantile'", "robustness.quantile=0.9"), store, "TP2")
    assert greedy is not None and greedy.index == favourite[0]


def test_of_finalists_that_do_equally_well_the_lightest_print_wins(store):
    masses = weigh_prints(study_of(), store)
    heavy, light, lightest = sorted(range(8), key=lambda index: -masses[index])[-3:]
    for index, score in ((heavy, 90.0), (light, 89.6), (lightest, 89.4)):
        store.add([], ("TP2", "TP6"), [scored(index, c, score) for c in range(4)])
    found = find_winner(study_of(), store, "TP2")
    assert found is not None and found.index == light
    # What has flown under the conditions of the promise stays chosen.
    store.add([], ("TP2", "TP6"), [scored(heavy, c, 90.0) for c in range(4, 13)])
    found = find_winner(study_of(), store, "TP2")
    assert found is not None and found.index == heavy


def test_of_equal_finalists_of_one_mass_the_best_undisturbed_flight_wins(store, monkeypatch):
    monkeypatch.setattr("driftform.search.finalists.hull_mass", lambda body: 0.05)
    best = store.find_best("TP2")
    assert best is not None
    store.add([], ("TP2", "TP6"), [scored(index, c, 90.0) for index in range(8) for c in range(4)])
    found = find_winner(study_of(), store, "TP2")
    assert found is not None and found.index == best[0]


def test_a_finalist_whose_round_was_interrupted_does_not_win_yet(store):
    store.add([], ("TP2", "TP6"), [scored(0, c, 100.0) for c in range(3)])
    assert find_winner(study_of(), store, "TP2") is None
    best = find_best_agent(study_of(), store, "TP2")
    assert best is not None and "robust" not in best.result and best.result["p90"] is None
    # One whose flights under the conditions of the promise were interrupted promises nothing yet.
    store.add([], ("TP2", "TP6"), [scored(0, c, 100.0) for c in range(3, 6)])
    best = find_best_agent(study_of(), store, "TP2")
    assert best is not None
    assert best.result["evaluation"] == 0 and best.result["median"] is None and best.result["p90"] is None


def test_without_conditions_nothing_is_flown(store):
    study = study_of("robustness.conditions=0")
    fly_finalists(study, store, InProcess(study.make_pipeline()))
    assert store.list_disturbed() == set()


def test_a_run_of_which_every_evaluation_failed_has_no_last_round(tmp_path):
    study, seen = study_of("simulator.step_limit=1"), []
    executor = InProcess(study.make_pipeline())
    with Store.create(tmp_path / "run.db", dict(study.document)) as store:
        run_search(study, store, executor)
        fly_finalists(study, store, executor, lambda done, total: seen.append((done, total)))
        assert store.list_disturbed() == set() and seen == []


def test_a_robust_fitness_is_the_mean_the_quantile_or_the_worst():
    fitness = np.array([90.0, 95.0, 85.0, 50.0])
    assert robust_fitness(fitness, Robustness(score="mean")) == 80.0
    assert robust_fitness(fitness, Robustness(score="worst")) == 50.0
    assert robust_fitness(fitness, Robustness(score="quantile", quantile=1 / 3)) == pytest.approx(85.0)


@pytest.mark.parametrize("quantile", [0.0, 0.1, 1 / 3, 0.5, 0.93, 1.0])
@pytest.mark.parametrize("conditions", [1, 2, 11, 24])
def test_the_quantile_of_a_robust_fitness_is_that_of_numpy_to_the_last_bit(conditions, quantile):
    fitness = np.random.default_rng(conditions).uniform(0, 100, (conditions, 5))
    found = robust_fitness(fitness, Robustness(score="quantile", quantile=quantile))
    assert np.array_equal(found, np.quantile(fitness, quantile, axis=0))


def test_finalists_are_the_best_for_any_target_and_the_earlier_of_equals():
    fitness, all_may = np.array([[5.0, 9.0], [7.0, 1.0], [7.0, 2.0], [1.0, 8.0]]), np.ones((4, 2), bool)
    assert choose_finalists(fitness, 1, all_may) == [0, 1]
    assert choose_finalists(fitness, 2, all_may) == [0, 1, 2, 3]
    assert choose_finalists(fitness, 2, np.array([[0, 0], [0, 0], [0, 1], [1, 0]], bool)) == [2, 3]


class Table:
    """An executor whose flights score what a table says, in the order in which genomes come."""

    def __init__(self, study, undisturbed, disturbed):
        self.conditions = draw_rounds(study)
        self.undisturbed, self.disturbed = undisturbed, disturbed
        self.rows = {}
        self.begin, self.miss = None, 1.0

    def evaluate(self, jobs):
        for job in jobs:
            row = self.rows.setdefault(job.genome, len(self.rows))
            scores = self.undisturbed[row]
            if job.condition is not None and job.condition.specimen is not Specimen.BASELINE:
                scores = self.disturbed[row, self.conditions.index(job.condition)]
            yield [(job.index, Evaluation(job.genome, scores, offsets=np.full((2, 3), self.miss)))]


@settings(max_examples=15, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    score=st.sampled_from(["quantile", "mean", "worst"]),
    level=st.sampled_from([90.0, 98.0]),
)
def test_the_race_has_the_winners_of_a_choice_in_which_all_fly(seed, score, level):
    rng = np.random.default_rng(seed)
    count = 12
    chosen = ("robustness.conditions=12", "robustness.survey=0")
    study = study_of(f"robustness.score='{score}'", *chosen, evaluations=count)
    undisturbed = rng.uniform(level, 101, (count, 2)).clip(max=100)
    reliable = rng.uniform(50, 100, (count, 1, 2))
    disturbed = np.minimum(reliable + rng.normal(0, 10, (count, 12 + 3 * len(FLOWN), 2)), 100).clip(min=0).round()
    executor = Table(study, undisturbed, disturbed)
    with TemporaryDirectory() as folder, Store.create(Path(folder) / "run.db", dict(study.document)) as store:
        run_search(study, store, executor)
        fly_finalists(study, store, executor)
        found = [find_winner(study, store, target) for target in ("TP2", "TP6")]
        masses = weigh_prints(study, store)
        flights = len(store.list_disturbed())
    near = undisturbed >= 95
    may = np.where(near.any(axis=0), near, True)
    finalists = {
        row for n in (0, 1) for row in sorted(np.flatnonzero(may[:, n]), key=lambda row: -undisturbed[row, n])[:2]
    }
    for number, winner in enumerate(found):
        scores = {
            int(row): float(robust_fitness(disturbed[row, :12, number], study.scenario.robustness))
            for row in finalists
            if may[row, number]
        }
        assert winner is not None and winner.index == find_lightest(scores, masses)
    assert flights <= 12 * len(finalists) + 9 * len({winner.index for winner in found if winner is not None}) + 6


def test_a_finalist_that_can_still_win_flies_on_and_the_promise_is_that_of_fresh_flights_alone(tmp_path):
    study = study_of("robustness.score='mean'", "robustness.conditions=12", "robustness.survey=0")
    undisturbed, disturbed = np.full((8, 2), 90.0), np.full((8, 12 + 3 * len(FLOWN), 2), 98.0)
    undisturbed[:2] = [[99.9], [99.5]]
    # The second is behind after the first look at the race, and wins because the rest of its flights are perfect.
    disturbed[1], disturbed[1, :ROUND] = 100.0, 95.5
    executor = Table(study, undisturbed, disturbed)
    with Store.create(tmp_path / "run.db", dict(study.document)) as store:
        run_search(study, store, executor)
        fly_finalists(study, store, executor)
        winner = find_winner(study, store, "TP2")
    assert winner is not None and winner.index == 1
    assert [winner.promises[specimen].misses.count for specimen in FLOWN] == [3] * len(FLOWN)


@pytest.mark.parametrize(("miss", "wins"), [(0.1, True), (1.0, False)])
def test_a_plain_body_that_keeps_its_target_wins_unless_another_is_better_by_a_tenth(tmp_path, monkeypatch, miss, wins):
    monkeypatch.setattr(finalists, "find_plain", lambda study, genomes: {1}.intersection(genomes))
    study = study_of("robustness.score='mean'", "robustness.conditions=4", "robustness.survey=0")
    undisturbed, disturbed = np.full((8, 2), 90.0), np.full((8, 4 + 3 * len(FLOWN), 2), 98.0)
    undisturbed[:2], disturbed[1] = [[99.9], [99.5]], 97.85
    executor = Table(study, undisturbed, disturbed)
    executor.miss = miss
    with Store.create(tmp_path / "run.db", dict(study.document)) as store:
        run_search(study, store, executor)
        fly_finalists(study, store, executor)
        assert (find_winner(study, store, "TP2").index == 1) == wins


def test_a_finalist_that_is_as_perfect_as_the_best_of_the_search_flies_on(tmp_path):
    study = study_of("robustness.score='worst'", "robustness.conditions=12", "robustness.survey=0")
    undisturbed, disturbed = np.full((8, 2), 90.0), np.full((8, 12 + 3 * len(FLOWN), 2), 100.0)
    undisturbed[:2] = [[99.9], [99.5]]
    with Store.create(tmp_path / "run.db", dict(study.document)) as store:
        executor = Table(study, undisturbed, disturbed)
        run_search(study, store, executor)
        fly_finalists(study, store, executor)
        assert set(range(12)) <= set(store.read_disturbed("TP2")[1])


def test_failed_flights_do_not_lower_a_score_unless_most_failed():
    fitness = np.array([[90.0, 90.0], [80.0, np.nan], [np.nan, np.nan]])
    for score, expected in (("mean", 85.0), ("worst", 80.0)):
        assert robust_fitness(fitness, Robustness(score=score)).tolist() == [expected, 0.0]


def test_a_baseline_is_tuned_for_its_target_and_flown_weighed_under_the_conditions_of_the_promise(tmp_path):
    options = {"targets": ["TP2", "TP6"], "use": {"simulator": "native", "strategy": "random"}}
    study = load_study("pipe-inspection", settings=SETTINGS, run={"seed": 2, "evaluations": 6}, **options)
    executor, pipeline = InProcess(study.make_pipeline()), study.make_pipeline()
    with Store.create(tmp_path / "run.db", dict(study.document)) as store:
        run_search(study, store, executor)
        fly_finalists(study, store, executor)
        found = {target: find_winner(study, store, target) for target in ("TP2", "TP6")}
        flown = len(store.list_disturbed())
        fly_finalists(study, store, executor)
        assert len(store.list_disturbed()) == flown
    for number, (target, winner) in enumerate(found.items()):
        assert winner is not None
        baseline = winner.baseline
        assert baseline is not None
        # TP2 lies above the axis, and TP6 too, farther away: both baselines rise.
        assert baseline.net_weight < 0
        misses = winner.promises[Specimen.BASELINE].misses
        weighed = winner.promises[Specimen.WEIGHED].misses.conditions
        assert [replace(c, specimen=Specimen.WEIGHED) for c in misses.conditions] == list(weighed)
        body = pipeline.make_agent(baseline.genome)
        assert body.mass.mass - 999.1 * body.mass.volume == pytest.approx(baseline.net_weight, abs=1e-9)
        [flight] = pipeline.evaluate([baseline.genome])
        near = 0.01 * study.scenario.pipe.farthest_distance(study.scenario.targets[target])
        assert np.linalg.norm(find_offsets(flight, study.scenario)[number]) < near
    assert found["TP2"].baseline.net_weight < found["TP6"].baseline.net_weight
