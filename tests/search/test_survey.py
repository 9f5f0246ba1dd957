"""The survey of a search: who is flown under disturbed conditions, and what the strategy receives."""

from itertools import chain

import numpy as np
import pytest

from driftform.runs.store import Record, Store
from driftform.search.finalists import fly_finalists
from driftform.search.jobs import Job
from driftform.search.journal import Journal
from driftform.search.local import InProcess
from driftform.search.loop import run_search
from driftform.search.survey import KEPT, Survey, read_scores
from driftform.study import load_study
from driftform.types import Candidate

TARGETS = ("TP2", "TP6")


def study_of(*settings, strategy="evolution", evaluations=24):
    return load_study(
        "paper",
        ("robustness.conditions=3", "robustness.checks=2", "robustness.finalists=2", "strategy.random=8", *settings),
        targets=list(TARGETS),
        use={"simulator": "native", "strategy": strategy},
        run={"seed": 4, "evaluations": evaluations},
    )


@pytest.fixture
def store(tmp_path):
    with Store.create(tmp_path / "run.db", {}) as store:
        yield store


def candidates_of(study, thresholds):
    grammar, rng = study.make_plugin("grammar"), np.random.default_rng(1)
    return [Candidate(grammar.random(rng), threshold=threshold) for threshold in thresholds]


def fly_batch(study, store, candidates):
    """The undisturbed flights, and what a strategy receives for them."""
    executor = InProcess(study.make_pipeline())
    jobs = [Job(number, candidate.genome) for number, candidate in enumerate(candidates)]
    flown = dict(chain.from_iterable(executor.evaluate(jobs)))
    flights = [flown[i] for i in range(len(candidates))]
    store.add([Record(i, c, e, 0) for i, (c, e) in enumerate(zip(candidates, flights, strict=True))], TARGETS)
    with Journal(store, TARGETS) as journal:
        return flights, Survey(study, journal, executor).fly(0, candidates, flights)


def mean_of(flight, flown):
    """The mean fitness of an undisturbed flight and of disturbed ones, (targets,)."""
    return np.asarray((flight.fitness + flown.sum(axis=0)) / (1 + len(flown)))


def disturbed(store, index):
    """Fitness of the disturbed flights of an evaluation, (flights, targets)."""
    return np.array(list(store.read_flights(TARGETS, index, index + 1).values()))


def test_a_strategy_receives_the_mean_of_all_flights_where_it_matters(store):
    study = study_of("robustness.survey=3")
    candidates = candidates_of(study, [(-1.0, -1.0), (100.0, 100.0), None])
    flights, received = fly_batch(study, store, candidates)
    assert received[0].fitness == pytest.approx(mean_of(flights[0], disturbed(store, 0)), abs=1e-12)
    assert not np.array_equal(received[0].fitness, flights[0].fitness)
    assert received[0].trajectory is flights[0].trajectory
    for number in (1, 2):
        assert received[number] is flights[number]
        assert disturbed(store, number).size == 0


def test_an_agent_that_falls_behind_the_best_under_the_same_conditions_flies_no_more(store):
    study = study_of("robustness.survey=8", "robustness.conditions=8", "robustness.finalists=1")
    executor = InProcess(study.make_pipeline())
    candidates = candidates_of(study, [(-1.0, 100.0)] * 6)
    jobs = [Job(number, candidate.genome) for number, candidate in enumerate(candidates)]
    flown = dict(chain.from_iterable(executor.evaluate(jobs)))
    store.add([Record(i, c, flown[i], 0) for i, c in enumerate(candidates)], TARGETS)
    with Journal(store, TARGETS) as journal:
        survey = Survey(study, journal, executor)
        for index, candidate in enumerate(candidates):
            survey.fly(index, [candidate], [flown[index]])
    flights = [disturbed(store, index) for index in range(6)]

    def mean(index, stage):
        return float(mean_of(flown[index], flights[index][:stage])[0])

    for index in range(6):
        expected = 8
        for stage in (2, 4):
            rivals = [mean(i, stage) for i in range(index) if len(flights[i]) >= stage]
            if rivals and mean(index, stage) <= max(rivals):
                expected = stage
                break
        assert len(flights[index]) == expected
    assert {len(each) for each in flights} >= {2, 8}


def test_an_agent_of_which_every_fitness_matters_flies_under_all_conditions_and_knows_what_it_keeps(store):
    study = study_of("robustness.survey=8", "robustness.conditions=8", "robustness.finalists=1")
    flights, received = fly_batch(study, store, candidates_of(study, [(-np.inf, -np.inf)] * 4))
    for index, (flight, given) in enumerate(zip(flights, received, strict=True)):
        flown = np.vstack([flight.fitness, disturbed(store, index)])
        assert flown.shape == (9, 2)
        assert given.measures == {**flight.measures, KEPT: pytest.approx(np.quantile(flown, 0.1, axis=0).mean())}


def test_without_disturbed_conditions_there_is_no_survey(store):
    study = study_of("robustness.conditions=0")
    flights, received = fly_batch(study, store, candidates_of(study, [(-1.0, -1.0)]))
    assert received[0] is flights[0]
    assert store.list_disturbed() == set()


def test_a_search_with_a_survey_is_resumed_without_loss(tmp_path):
    study, kept = study_of(), []
    for name, parts in (("whole", (24,)), ("parts", (11, 24))):
        with Store.create(tmp_path / f"{name}.db", {}) as store:
            for evaluations in parts:
                part = study_of(evaluations=evaluations)
                run_search(part, store, InProcess(part.make_pipeline()))
            rows = [(r.index, r.candidate, r.evaluation.fitness.tobytes()) for r in store.read_records(TARGETS)]
            kept.append((rows, store.list_disturbed(), read_scores(study, store).keys()))
    assert kept[0] == kept[1]
    assert 0 < len(kept[0][1]) < 3 * 24


def test_the_finalists_are_those_of_the_best_mean_in_the_survey(store):
    study = study_of("robustness.conditions=5", "robustness.survey=3")
    executor = InProcess(study.make_pipeline())
    run_search(study, store, executor)
    scores = read_scores(study, store)
    fly_finalists(study, store, executor)
    judged = {index for index, number in store.list_disturbed() if number == 3}
    flights = {index: store.read_record(index, TARGETS).evaluation for index in scores}
    best = set()
    for number in range(len(TARGETS)):
        ranked = sorted(scores, key=lambda index: (-scores[index][number], index))
        # One that comes near its target undisturbed goes before all that do not.
        near = [index for index in ranked if flights[index].fitness[number] >= 95]
        best |= set((near or ranked)[:2])
    assert judged == best
    for index in scores:
        assert scores[index] == pytest.approx(mean_of(flights[index], disturbed(store, index)[:3]))
