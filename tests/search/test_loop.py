"""The ask/tell loop: what it stores, how it goes on, and what it refuses."""

from dataclasses import replace
from itertools import chain

import numpy as np
import pytest

from driftform.errors import InputError, WorkFailedError
from driftform.pipeline import MARGIN
from driftform.runs.run import StoredRun
from driftform.runs.store import Store
from driftform.search.journal import UNWRITTEN_S
from driftform.search.local import InProcess
from driftform.search.loop import run_search
from driftform.search.results import write_results
from driftform.search.survey import BestFitness
from driftform.study import load_study
from driftform.types import Evaluation, Genome
from driftform_strategies.random import RandomStrategy

pytestmark = pytest.mark.usefixtures("fakes")


def study_of(*settings, evaluations=25, strategy="paper", **more):
    return load_study(
        "paper",
        settings,
        use={"simulator": "fake", "strategy": strategy},
        targets=["TP1", "TP6"],
        run={"seed": 3, "evaluations": evaluations, **more},
    )


SMALL = {"paper": [], "random": ["strategy.batch=1"], "evolution": ["strategy.random=8", "strategy.batch=4"]}
"""Settings with which 25 evaluations are several batches."""


def rows(store, study):
    return [
        (r.index, r.candidate, r.evaluation.fitness.tobytes(), r.evaluation.failure)
        for r in store.read_records(study.scenario.target_names)
    ]


@pytest.fixture
def store(tmp_path):
    with Store.create(tmp_path / "run.db", {}) as store:
        yield store


class Counting:
    """Evaluates in this process, backwards, and remembers what it was asked for."""

    def __init__(self, study, breaks_after=None):
        self._executor = InProcess(study.make_pipeline())
        self.begin = self._executor.begin
        self._left = breaks_after
        self.asked = []

    def evaluate(self, jobs):
        for outcome in list(chain.from_iterable(self._executor.evaluate(jobs)))[::-1]:
            if self._left is not None:
                if self._left == 0:
                    raise KeyboardInterrupt
                self._left -= 1
            self.asked.append(outcome[0])
            yield [outcome]


@pytest.mark.parametrize("strategy", ["paper", "random", "evolution"])
@pytest.mark.parametrize("stop", [0, 1, 7, 20, 24])
def test_stopped_anywhere_it_goes_on_to_the_same_result_and_flies_nothing_twice(store, tmp_path, strategy, stop):
    study = study_of(*SMALL[strategy], strategy=strategy)
    with Store.create(tmp_path / "whole.db", {}) as whole:
        run_search(study, whole, Counting(study))
        expected = rows(whole, study)
        # Each flight has gusts of its own.
        assert len({record.seed for record in whole.read_records(study.scenario.target_names)}) == 25
    first = Counting(study, breaks_after=stop)
    with pytest.raises(KeyboardInterrupt):
        run_search(study, store, first)
    assert store.count() == stop
    second = Counting(study)
    run_search(study, store, second)
    assert rows(store, study) == expected
    assert sorted(first.asked + second.asked) == list(range(25))


class Timed(Counting):
    """The same; each evaluation took as long as is said."""

    def __init__(self, study, seconds):
        super().__init__(study)
        self._seconds = seconds

    def evaluate(self, jobs):
        for outcomes in super().evaluate(jobs):
            yield [(index, replace(evaluation, seconds=self._seconds)) for index, evaluation in outcomes]


@pytest.mark.parametrize("seconds", [UNWRITTEN_S / 10.5, 2 * UNWRITTEN_S])
def test_a_kill_loses_no_more_than_the_work_of_a_moment_and_nothing_that_was_shown(store, monkeypatch, seconds):
    lost = []
    seen = []
    evaluate = Timed.evaluate

    def watch(self, jobs):
        for number, outcomes in enumerate(evaluate(self, jobs)):
            with Store.open(store._path, read_only=True) as what_a_kill_leaves:
                stored = [r.index for r in what_a_kill_leaves.read_records(study.scenario.target_names)]
            assert set(seen) <= set(stored)
            lost.append(number - len(stored))
            yield outcomes

    monkeypatch.setattr(Timed, "evaluate", watch)
    study = study_of("strategy.batch=25", strategy="random")
    run_search(study, store, Timed(study, seconds), lambda record: seen.append(record.index))
    assert max(lost) == (10 if seconds < UNWRITTEN_S else 0)
    assert sorted(seen) == list(range(25))


@pytest.mark.parametrize("ahead", [False, True])
def test_a_strategy_that_can_is_asked_for_one_batch_while_another_is_flown(store, monkeypatch, ahead):
    calls = []

    def record(name):
        usual = getattr(RandomStrategy, name)

        def call(*args):
            calls.append(name)
            return usual(*args)

        monkeypatch.setattr(RandomStrategy, name, call)

    record("ask")
    record("tell")
    monkeypatch.setattr(RandomStrategy, "can_ask_ahead", lambda self: ahead)
    study = study_of("strategy.batch=10", strategy="random")
    run_search(study, store, Counting(study))
    assert calls == (["ask", "ask", "tell", "ask", "tell", "tell"] if ahead else ["ask", "tell"] * 3)


def screened_study(strategy):
    batch = {"random": "strategy.batch=10", "evolution": "strategy.random=10"}[strategy]
    return load_study(
        "paper",
        [batch],
        use={"simulator": "native", "strategy": strategy},
        targets=["TP5", "TP8"],
        run={"seed": 3, "evaluations": 60},
    )


@pytest.mark.long
@pytest.mark.parametrize("strategy", ["random", "evolution"])
def test_what_a_run_shows_is_checked_and_what_is_not_checked_is_not_among_its_best(store, strategy):
    study = screened_study(strategy)
    run_search(study, store, InProcess(study.make_pipeline()))
    records = list(store.read_records(study.scenario.target_names))
    checked = [error_of(record) is not None for record in records]
    assert 10 < sum(checked) < 50
    fitness = np.array([record.evaluation.fitness for record in records])
    for index in np.flatnonzero(np.logical_not(checked)):
        assert np.all(fitness[index] < fitness[:index].max(axis=0) - MARGIN)
    # The same genomes with all flights checked have the same best ones.
    whole = study.make_pipeline().evaluate([record.candidate.genome for record in records])
    expected = np.array([evaluation.fitness for evaluation in whole])
    np.testing.assert_array_equal(expected[checked], fitness[checked])
    np.testing.assert_array_equal(expected.max(axis=0), fitness.max(axis=0))


def test_which_flights_are_checked_depends_neither_on_their_order_nor_on_a_stop(store, tmp_path):
    study = screened_study("evolution")
    targets = study.scenario.target_names
    with Store.create(tmp_path / "whole.db", {}) as whole:
        run_search(study, whole, InProcess(study.make_pipeline()))
        expected = rows(whole, study), [error_of(record) for record in whole.read_records(targets)]
    with pytest.raises(KeyboardInterrupt):
        run_search(study, store, Counting(study, breaks_after=34))
    run_search(study, store, Counting(study))
    assert (rows(store, study), [error_of(record) for record in store.read_records(targets)]) == expected


def error_of(record):
    trajectory = record.evaluation.trajectory
    assert trajectory is not None
    return trajectory.error


def test_a_strategy_that_uses_every_fitness_has_every_flight_checked(store):
    study = load_study(
        "paper", use={"simulator": "native", "strategy": "paper"}, targets=["TP1"], run={"evaluations": 20}
    )
    run_search(study, store, InProcess(study.make_pipeline()))
    assert all(flight.error is not None for _, flight in store.read_trajectories())


def test_the_best_fitness_lowers_a_threshold_and_failures_do_not_count():
    genome, best = Genome("letters", ("A",)), BestFitness(targets=2, count=2)
    assert best.lower_threshold((50.0, np.inf)) == (-np.inf, -np.inf)
    best.add([Evaluation(genome, np.array(values)) for values in ([10.0, 20.0], [30.0, 5.0], [20.0, 1.0])])
    best.add([Evaluation(genome, np.array([99.0, 99.0]), failure="it broke")])
    assert best.lower_threshold((50.0, np.inf)) == (20.0, 5.0)
    assert best.lower_threshold((15.0, 2.0)) == (15.0, 2.0)
    assert best.lower_threshold(None) is None


def test_a_finished_run_is_replayed_without_a_flight(store):
    study = study_of()
    run_search(study, store, Counting(study))
    before = rows(store, study)
    again = Counting(study)
    seen = []
    run_search(study, store, again, seen.append)
    assert again.asked == []
    assert len(seen) == 25
    assert rows(store, study) == before


def test_a_run_that_its_study_would_not_make_now_is_refused(store):
    run_search(study_of(), store, Counting(study_of()))
    other = load_study("paper", use={"simulator": "fake"}, targets=["TP1", "TP6"], run={"seed": 4})
    with pytest.raises(InputError, match=r"evaluation 0 of this run is not the one .* environment\.json"):
        run_search(other, store, Counting(other))


def test_failures_are_recorded_with_their_reason_and_the_run_goes_on(store):
    study = study_of("simulator.fail=0.5")
    run_search(study, store, Counting(study))
    assert 0 < store.count_failed() < store.count() == 25
    failures = {r.evaluation.failure for r in store.read_records(study.scenario.target_names)} - {None}
    assert all("simulator 'fake' failed in simulate(): RuntimeError: genome 0." in str(failure) for failure in failures)
    # The failures differ in their numbers alone.
    reason, count = store.find_commonest_failure()
    assert reason in failures
    assert count == store.count_failed()


@pytest.mark.parametrize("slip", ["nan", "infinite", "negative", "too many", "too few"])
def test_a_fitness_that_no_selection_can_work_with_is_a_failure(store, tmp_path, slip):
    study = study_of("fitness.use=slipping", f"fitness.slip='{slip}'")
    run_search(study, store, Counting(study))
    assert store.count_failed() == 25
    with pytest.raises(
        WorkFailedError, match="all 25 evaluations failed, 25 of them like this: fitness 'slipping' returned"
    ):
        write_results(StoredRun(tmp_path, study), InProcess(study.make_pipeline()))


def test_the_best_of_each_target_is_written(store, tmp_path):
    study = study_of(formats=["scad"])
    run_search(study, store, Counting(study))
    results = write_results(StoredRun(tmp_path, study), InProcess(study.make_pipeline()))
    overview = tmp_path / "figures" / "overview.svg"
    assert overview.is_file()
    for number, best in enumerate(results):
        records = list(store.read_records(study.scenario.target_names))
        fitness = [record.evaluation.fitness[number] for record in records]
        assert best.result["fitness"] == max(fitness)
        assert best.result["evaluation"] == int(np.argmax(fitness))
        assert {path.name for path in best.files} == {"agent.json", "trajectory.csv", "section.svg", "agent.scad"}
        # Equation 25 backwards, with the stored flight in place of the one that was scored.
        d_max = study.scenario.pipe.farthest_distance(np.array(study.scenario.targets[best.target]))
        assert best.result["nominal"] == pytest.approx(best.result["error_percent"] / 100 * d_max, rel=1e-3)
    # Written again, they are the same.
    files = {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file() and "run.db" not in p.name}
    write_results(StoredRun(tmp_path, study), InProcess(study.make_pipeline()))
    assert {p: p.read_bytes() for p in files} == files
