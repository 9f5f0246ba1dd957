"""The last round: who is flown again, and who wins."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from driftform.execution import InProcess
from driftform.runs.finalists import find_best_agent, find_winner, fly_finalists
from driftform.runs.search import run_search
from driftform.runs.store import DisturbedResult, Store
from driftform.scenario.disturbances import robust_fitness
from driftform.study import Study, load_study

SETTINGS = ("robustness.conditions=4", "robustness.finalists=2")


def study_of(*settings: str) -> Study:
    return load_study(
        settings=(*SETTINGS, *settings),
        targets=["TP2", "TP6"],
        use={"simulator": "native", "strategy": "random"},
        run={"seed": 2, "evaluations": 8},
    )


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    study = study_of()
    with Store.create(tmp_path / "run.db", dict(study.document)) as store:
        run_search(study, store, InProcess(study.make_pipeline()))
        yield store


def test_the_finalists_of_every_target_are_flown_under_every_condition_once(store: Store) -> None:
    study, seen = study_of(), []
    executor = InProcess(study.make_pipeline())
    fly_finalists(study, store, executor, lambda done, total: seen.append((done, total)))
    fitness = np.array([brief.fitness for brief in store.read_summaries(("TP2", "TP6"))])
    expected = sorted({int(i) for column in fitness.T for i in np.argsort(-column)[:2]})
    for target in ("TP2", "TP6"):
        assert [index for index, _, _ in store.read_disturbed(target)] == expected
        assert all(len(flights) == 4 for _, flights, _ in store.read_disturbed(target))
    total = 4 * len(expected)
    assert seen[0] == (0, total) and seen[-1] == (total, total)
    assert all(a < b for (a, _), (b, _) in pairwise(seen))
    again: list[tuple[int, int]] = []
    fly_finalists(study, store, executor, lambda done, total: again.append((done, total)))
    assert again == [(total, total)]


def test_what_is_stored_is_what_the_pipeline_finds_under_that_condition(store: Store) -> None:
    study = study_of()
    fly_finalists(study, store, InProcess(study.make_pipeline()))
    index, flights, failed = store.read_disturbed("TP6")[0]
    genome = store.read_record(index, ("TP2", "TP6")).candidate.genome
    evaluations = study.make_pipeline().evaluate([genome] * 4, disturbed=[0, 1, 2, 3])
    assert failed == 0
    assert flights.tolist() == [float(evaluation.fitness[1]) for evaluation in evaluations]


def test_the_best_agent_is_the_one_that_won_the_last_round(store: Store) -> None:
    study = study_of()
    fly_finalists(study, store, InProcess(study.make_pipeline()))
    for number, target in enumerate(("TP2", "TP6")):
        scores = {
            i: robust_fitness(f[:, None], study.scenario.robustness)[0]
            for i, f, _ in store.read_disturbed(target)
        }
        best = find_best_agent(study, store, target)
        assert best is not None
        assert best.result["evaluation"] == max(scores, key=lambda index: scores[index])
        assert best.result["robust"]["score"] == pytest.approx(max(scores.values()))
        record = store.read_record(best.result["evaluation"], ("TP2", "TP6"))
        assert best.result["fitness"] == record.evaluation.fitness[number]
        assert best.genome == record.candidate.genome


def test_one_that_is_best_undisturbed_loses_to_one_that_can_be_relied_on(store: Store) -> None:
    study = study_of()
    favourite = store.find_best("TP2")
    assert favourite is not None
    other = next(i for i in range(8) if i != favourite[0])
    steady, fickle = np.array([70.0, 50.0]), [np.array([99.0, 50.0])] * 2 + [np.array([10.0, 50.0])] * 2
    store.add_disturbed([DisturbedResult(other, c, steady) for c in range(4)], ("TP2", "TP6"))
    store.add_disturbed([DisturbedResult(favourite[0], c, fickle[c]) for c in range(4)], ("TP2", "TP6"))
    found = find_winner(study, store, "TP2")
    assert found is not None
    assert (found.index, found.fitness) == (other, 70.0)
    greedy = find_winner(study_of("robustness.score='quantile'", "robustness.quantile=0.9"), store, "TP2")
    assert greedy is not None and greedy.index == favourite[0]


def test_a_finalist_whose_round_was_interrupted_does_not_win_yet(store: Store) -> None:
    store.add_disturbed([DisturbedResult(0, c, np.array([100.0, 100.0])) for c in range(3)], ("TP2", "TP6"))
    assert find_winner(study_of(), store, "TP2") is None
    best = find_best_agent(study_of(), store, "TP2")
    assert best is not None and "robust" not in best.result


def test_without_conditions_nothing_is_flown(store: Store) -> None:
    study = study_of("robustness.conditions=0")
    fly_finalists(study, store, InProcess(study.make_pipeline()))
    assert store.list_disturbed() == set()
