"""Where evaluations run: worker processes that crash cost nothing but the genome that is to blame."""

import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from driftform.execution import ATTEMPTS, InProcess, Job, LocalProcesses, Outcome
from driftform.study import Study, load_study
from driftform.types import Evaluation

pytestmark = pytest.mark.usefixtures("fakes")

COUNT = 24


def study_of(**options: Any) -> Study:
    settings = [f"simulator.{key}={value!r}" for key, value in options.items()]
    return load_study(None, settings, use={"simulator": "fake"}, targets=["TP1", "TP6"], run={"seed": 1})


@pytest.fixture(scope="module")
def jobs() -> list[Job]:
    grammar = load_study().plugin("grammar")
    rng = np.random.default_rng(5)
    return [(10 + index, grammar.random(rng)) for index in range(COUNT)]


def number(genome: Any) -> float:
    from driftform_fake import number

    return float(number(genome))


def told(outcomes: Iterator[Outcome]) -> dict[int, Evaluation]:
    found: dict[int, Evaluation] = {}
    for index, evaluation in outcomes:
        assert index not in found, "an outcome came twice"
        found[index] = evaluation
    return found


def assert_same(a: dict[int, Evaluation], b: dict[int, Evaluation]) -> None:
    assert a.keys() == b.keys()
    for index, left in a.items():
        right = b[index]
        assert (left.genome, left.failure) == (right.genome, right.failure)
        assert left.fitness.tobytes() == right.fitness.tobytes()
        assert (left.trajectory is None) == (right.trajectory is None)
        if left.trajectory is not None and right.trajectory is not None:
            assert left.trajectory.position.tobytes() == right.trajectory.position.tobytes()


def test_processes_find_what_this_process_finds(jobs: list[Job]) -> None:
    study = study_of()
    here = told(InProcess(study.pipeline()).evaluate(jobs))
    with closing(LocalProcesses(study.document, 2)) as executor:
        there = told(executor.evaluate(jobs))
        again = told(executor.evaluate(jobs[:3]))
        assert told(executor.evaluate([])) == {}
    assert sorted(here) == [index for index, _ in jobs]
    assert_same(here, there)
    assert_same({index: here[index] for index, _ in jobs[:3]}, again)


def test_a_genome_that_raises_is_a_failure_of_its_own(jobs: list[Job]) -> None:
    sound = told(InProcess(study_of().pipeline()).evaluate(jobs))
    outcomes = told(InProcess(study_of(fail=0.3).pipeline()).evaluate(jobs))
    guilty = {index for index, genome in jobs if number(genome) > 0.7}
    assert 0 < len(guilty) < COUNT
    for index, evaluation in outcomes.items():
        if index in guilty:
            assert "RuntimeError: genome 0." in str(evaluation.failure)
            assert evaluation.fitness.tolist() == [0.0, 0.0]
        else:
            assert_same({index: evaluation}, {index: sound[index]})


def test_a_genome_that_kills_its_process_fails_and_all_others_are_evaluated(jobs: list[Job]) -> None:
    sound = told(InProcess(study_of().pipeline()).evaluate(jobs))
    guilty = {index for index, genome in jobs if number(genome) < 0.1}
    assert 0 < len(guilty) < COUNT / 3
    with closing(LocalProcesses(study_of(die=0.1).document, 2)) as executor:
        outcomes = told(executor.evaluate(jobs))
    assert outcomes.keys() == sound.keys()
    for index, evaluation in outcomes.items():
        if index in guilty:
            assert evaluation.failure == f"its process died {ATTEMPTS} times"
            assert evaluation.fitness.tolist() == [0.0, 0.0]
        else:
            assert_same({index: evaluation}, {index: sound[index]})


def test_a_process_that_dies_once_is_forgiven(jobs: list[Job], tmp_path: Path) -> None:
    options = {"die": 0.1, "die_once": str(tmp_path)}
    with closing(LocalProcesses(study_of(**options).document, 2)) as executor:
        outcomes = told(executor.evaluate(jobs))
    assert list(tmp_path.iterdir())
    assert_same(outcomes, told(InProcess(study_of().pipeline()).evaluate(jobs)))


@pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")
def test_a_worker_that_is_killed_from_outside_costs_nothing(jobs: list[Job]) -> None:
    import multiprocessing

    study = study_of(pause=0.05)
    found: dict[int, Evaluation] = {}
    with closing(LocalProcesses(study.document, 2)) as executor:
        for index, evaluation in executor.evaluate(jobs):
            if not found:
                os.kill(multiprocessing.active_children()[0].pid or 0, signal.SIGKILL)
            assert index not in found
            found[index] = evaluation
        # One that waits for work may be killed as well.
        for child in multiprocessing.active_children():
            os.kill(child.pid or 0, signal.SIGKILL)
        again = told(executor.evaluate(jobs[:2]))
    sound = told(InProcess(study.pipeline()).evaluate(jobs))
    assert_same(found, sound)
    assert_same(again, {index: sound[index] for index, _ in jobs[:2]})


def test_closed_in_the_middle_it_does_not_wait_and_leaves_no_process(jobs: list[Job]) -> None:
    import multiprocessing

    executor = LocalProcesses(study_of(pause=1.5).document, 2)
    outcomes = iter(executor.evaluate(jobs))
    next(outcomes)
    began = time.monotonic()
    executor.close()
    assert time.monotonic() - began < 1.5
    assert multiprocessing.active_children() == []
    executor.close()
