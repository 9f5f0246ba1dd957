"""Evaluations in this process, in local processes and on a cluster: the same result, whatever dies."""

import json
import multiprocessing
import os
import re
import signal
import sys
import threading
import time
from contextlib import closing
from functools import partial
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

from driftform.errors import InputError
from driftform.search.cluster import Cluster
from driftform.search.jobs import ATTEMPTS, Job, WorkerDiedError, WorkersLostError, evaluate_batch
from driftform.search.local import InProcess, LocalProcesses
from driftform.study import Study, load_study
from driftform.util.files import remove_parts

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("fakes")]

COUNT = 24


def study_of(timeout=60.0, **options):
    settings = [f"simulator.{key}={json.dumps(value)}" for key, value in options.items()]
    settings.append(f"run.evaluation_timeout={timeout}")
    return load_study("paper", settings, use={"simulator": "fake"}, targets=["TP1", "TP6"], run={"seed": 1})


@pytest.fixture(scope="module")
def jobs():
    grammar = load_study("paper").make_plugin("grammar")
    rng = np.random.default_rng(5)
    return [Job(10 + index, grammar.random(rng)) for index in range(COUNT)]


@pytest.fixture(params=["local", pytest.param("dask", marks=pytest.mark.peers)])
def make(request):
    """Makes an executor with two workers: local processes, or those of a running cluster."""
    if request.param == "local":
        return lambda study: LocalProcesses(study.document, 2)
    address = request.getfixturevalue("dask_cluster")
    return lambda study: Cluster(study.document, address)


def workers_of(executor):
    """The processes that evaluate."""
    if isinstance(executor, Cluster):
        return list(executor._client.run(os.getpid).values())
    return [child.pid or 0 for child in multiprocessing.active_children()]


def number(genome):
    from driftform_fake import number

    return float(number(genome))


def collect(outcomes):
    found = {}
    for index, evaluation in chain.from_iterable(outcomes):
        assert index not in found, "an outcome arrived twice"
        found[index] = evaluation
    return found


def assert_same(a, b):
    assert a.keys() == b.keys()
    for index, left in a.items():
        right = b[index]
        assert (left.genome, left.failure) == (right.genome, right.failure)
        assert left.fitness.tobytes() == right.fitness.tobytes()
        assert (left.trajectory is None) == (right.trajectory is None)
        if left.trajectory is not None and right.trajectory is not None:
            assert left.trajectory.position.tobytes() == right.trajectory.position.tobytes()


def test_workers_find_what_this_process_finds(jobs, make):
    study = study_of()
    here = collect(InProcess(study.make_pipeline()).evaluate(jobs))
    with closing(make(study)) as executor:
        there = collect(executor.evaluate(jobs))
        again = collect(executor.evaluate(jobs[:3]))
        assert collect(executor.evaluate([])) == {}
    assert sorted(here) == [job.index for job in jobs]
    assert_same(here, there)
    assert_same({job.index: here[job.index] for job in jobs[:3]}, again)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"die": 0.08}, f"its process died {ATTEMPTS} times (exit code 1)"),
        ({"hang": 0.08, "timeout": 0.5}, "its evaluation did not end within 0.5 s (run.evaluation_timeout)"),
    ],
    ids=["killed", "endless"],
)
def test_a_genome_that_kills_its_process_or_never_ends_fails_and_all_others_are_evaluated(jobs, make, options, reason):
    sound = collect(InProcess(study_of().make_pipeline()).evaluate(jobs))
    guilty = {job.index for job in jobs if number(job.genome) < 0.08}
    assert 0 < len(guilty) < COUNT / 3
    with closing(make(study_of(**options))) as executor:
        outcomes = collect(executor.evaluate(jobs))
    assert outcomes.keys() == sound.keys()
    for index, evaluation in outcomes.items():
        if index in guilty:
            assert evaluation.failure == reason
            assert evaluation.fitness.tolist() == [0.0, 0.0]
        else:
            assert_same({index: evaluation}, {index: sound[index]})


def test_a_process_that_dies_once_is_forgiven(jobs, make, tmp_path):
    options = {"die": 0.08, "die_once": str(tmp_path)}
    with closing(make(study_of(**options))) as executor:
        outcomes = collect(executor.evaluate(jobs))
    assert list(tmp_path.iterdir())
    assert_same(outcomes, collect(InProcess(study_of().make_pipeline()).evaluate(jobs)))


@pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")
def test_a_worker_that_is_killed_from_outside_costs_nothing(jobs, make):
    study = study_of(pause=0.05)
    found = {}
    with closing(make(study)) as executor:
        for index, evaluation in chain.from_iterable(executor.evaluate(jobs)):
            if not found:
                os.kill(workers_of(executor)[0], signal.SIGKILL)
            assert index not in found
            found[index] = evaluation
        # A worker that waits for work may be killed as well.
        os.kill(workers_of(executor)[0], signal.SIGKILL)
        again = collect(executor.evaluate(jobs[:2]))
    sound = collect(InProcess(study.make_pipeline()).evaluate(jobs))
    assert_same(found, sound)
    assert_same(again, {job.index: sound[job.index] for job in jobs[:2]})


@pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")
@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("SIGSEGV", "its process died 5 times (SIGSEGV)"),
        ("SIGABRT", "its process died 5 times (SIGABRT)"),
        ("SIGKILL", "its process died 5 times (SIGKILL, from outside or for want of memory)"),
    ],
)
def test_a_genome_that_ends_its_process_by_a_signal_fails_with_the_signal(jobs, name, reason):
    [guilty] = sorted((job for job in jobs if number(job.genome) < 0.08), key=lambda job: job.index)[:1]
    innocent = next(job for job in jobs if number(job.genome) > 0.5)
    with closing(LocalProcesses(study_of(die=0.08, signal=name).document, 1)) as executor:
        outcomes = collect(executor.evaluate([innocent, guilty]))
    assert outcomes[guilty.index].failure == reason
    assert outcomes[innocent.index].failure is None


def test_workers_that_cannot_start_stop_the_run_and_no_genome_is_blamed(jobs):
    with (
        closing(LocalProcesses(study_of(stillborn=True).document, 2)) as executor,
        pytest.raises(WorkersLostError, match=r"^workers cannot start here: .*\(exit code 3\)$"),
    ):
        list(executor.evaluate(jobs))


def test_a_preparation_is_no_part_of_the_time_limit(jobs, make):
    with closing(make(study_of(deed="prepare", timeout=3.0))) as executor:
        outcomes = collect(executor.evaluate(jobs[:1]))
    assert [evaluation.failure for evaluation in outcomes.values()] == [None]


@pytest.mark.parametrize("deed", ["interrupt", "generator"])
def test_whatever_a_plugin_raises_costs_its_genome_alone(jobs, make, deed):
    with closing(make(study_of(deed=deed))) as executor:
        outcomes = collect(executor.evaluate(jobs[:4]))
    assert len(outcomes) == 4
    for evaluation in outcomes.values():
        assert evaluation.failure is not None and evaluation.failure.startswith("simulator 'fake' failed in simulate()")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not clone processes")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_clone_of_a_worker_answers_nothing(jobs, make):
    with closing(make(study_of(deed="clone"))) as executor:
        outcomes = collect(executor.evaluate(jobs))
    assert outcomes.keys() == {job.index for job in jobs}
    for job in jobs:
        evaluation = outcomes[job.index]
        assert evaluation.genome == job.genome and evaluation.failure is None
        assert evaluation.trajectory is not None and evaluation.trajectory.position[0, 0] == 0


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads /proc")
def test_clones_of_workers_end_with_them(jobs):
    with closing(LocalProcesses(study_of(deed="clone and wait").document, 1)) as executor:
        collect(executor.evaluate(jobs[:3]))
        [worker] = workers_of(executor)
        clones = [p for p in Path("/proc").glob("[0-9]*") if f" {worker} {worker} " in _read_stat(p)]
        assert len(clones) == 3
    time.sleep(0.5)
    assert not [p for p in clones if " Z " not in (stat := _read_stat(p)) and stat]


def _read_stat(process):
    """State, parent, group and more of a process; nothing if it has ended."""
    try:
        return (process / "stat").read_text().rpartition(")")[2]
    except OSError:
        return ""


def test_a_plugin_that_leaves_the_directory_moves_nobody(jobs, make, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with closing(make(study_of(deed="move"))) as executor:
        collect(executor.evaluate(jobs[:4]))
        assert {str(path) for path in executor.call([Path.cwd, Path.cwd])} == {str(tmp_path)}
    collect(InProcess(study_of(deed="move").make_pipeline()).evaluate(jobs[:2]))
    assert Path.cwd() == tmp_path


def test_closing_in_the_middle_does_not_wait_and_leaves_no_process(jobs):
    executor = LocalProcesses(study_of(pause=600.0).document, 2)
    flight = executor._submit(evaluate_batch, jobs[:1])
    time.sleep(1)
    executor.close()
    assert isinstance(flight.exception(), WorkerDiedError)
    assert multiprocessing.active_children() == []
    executor.close()


@pytest.mark.parametrize("count", [1, 5])
def test_processes_that_are_started_before_their_first_task_are_those_that_evaluate(jobs, count):
    with closing(LocalProcesses(study_of().document, 2, start=count)) as executor:
        started = set(workers_of(executor))
        assert len(started) == min(count, 2)
        outcomes = collect(executor.evaluate(jobs))
        assert started <= set(workers_of(executor)) and len(workers_of(executor)) == 2
    assert_same(outcomes, collect(InProcess(study_of().make_pipeline()).evaluate(jobs)))


def test_an_error_in_a_study_is_raised_and_no_genome_is_blamed(jobs, make):
    study = study_of()
    broken = Study({**study.document, "simulator": {"use": "fake", "pause": -1.0}}, study.scenario, study.run)
    with closing(make(broken)) as executor, pytest.raises(InputError, match=r"simulator\.pause = -1\.0"):
        list(executor.evaluate(jobs))


def harm(name):
    """A function that worker processes can import, and that does harm."""
    import driftform_fake

    return getattr(driftform_fake, name)


def test_functions_are_called_in_processes_that_run_already(jobs):
    with closing(LocalProcesses(study_of().document, 2)) as executor:
        list(executor.evaluate(jobs))
        workers = set(workers_of(executor))
        assert set(executor.call([os.getpid] * 4)) == workers
        with pytest.raises(InputError, match="no"):
            list(executor.call([harm("refuse"), os.getpid]))
        assert workers_of(executor) == []


@pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")
def test_a_function_that_ends_its_process_once_is_called_again_in_a_new_one(tmp_path):
    with closing(LocalProcesses(study_of().document, 2)) as executor:
        die_once = partial(harm("die_once"), tmp_path / "marker")
        found = executor.call([partial(abs, 1), die_once, partial(abs, 2), partial(abs, 3)])
        assert list(found) == [1, "alive", 2, 3]


@pytest.mark.parametrize(("deed", "text"), [("exit", "exit code 3"), ("segfault", "SIGSEGV")])
@pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")
def test_a_function_that_always_ends_its_process_is_named_by_its_place_and_its_end(deed, text):
    with closing(LocalProcesses(study_of().document, 2)) as executor:
        found = executor.call([partial(abs, 1), partial(abs, 2), partial(harm("end_process"), deed), partial(abs, 3)])
        assert [next(found), next(found)] == [1, 2]
        with pytest.raises(WorkerDiedError, match=re.escape(f"its process died ({text})")):
            next(found)
        assert workers_of(executor) == []


@pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")
def test_a_worker_that_dies_while_it_sends_its_result_is_not_waited_for(jobs, tmp_path):
    executor = LocalProcesses(study_of().document, 1)
    list(executor.evaluate(jobs[:1]))
    found = []

    def call():
        found.extend(executor.call([partial(harm("die_while_sending"), tmp_path / "marker")]))

    caller = threading.Thread(target=call, daemon=True)
    caller.start()
    caller.join(600)
    assert found == ["alive"]
    executor.close()
    assert multiprocessing.active_children() == []


@pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")
def test_an_interruption_of_functions_leaves_nothing_half_written(jobs, tmp_path):
    with closing(LocalProcesses(study_of().document, 1)) as executor:
        list(executor.evaluate(jobs[:2]))
        interrupt = threading.Timer(2.0, os.kill, [os.getpid(), signal.SIGINT])
        interrupt.start()
        with pytest.raises(KeyboardInterrupt):
            list(executor.call([partial(harm("write_slowly"), tmp_path / "file")]))
        remove_parts(tmp_path)
    assert list(tmp_path.iterdir()) == []
