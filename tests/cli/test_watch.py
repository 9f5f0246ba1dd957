"""Looking on at a run: what is told is true, and the run does not notice."""

import json
import os
import re
import signal
import sys
import threading
import time
from contextlib import ExitStack

import numpy as np
import pytest
from processes import count_evaluations, look, make_arguments, read_until, start_on_terminal, wait_until

from driftform.runs.directory import is_worked_on, lock_run
from driftform.runs.store import Record, Store
from driftform.types import Candidate, Evaluation, Genome

EVALUATIONS = 36
STUDY = make_arguments(EVALUATIONS)


def add(store, *indices):
    genome = Genome("g", ())
    fitness = {i: np.array([50.0 if i > 4 else 10.0 * i]) for i in indices}
    store.add([Record(i, Candidate(genome), Evaluation(genome, fitness[i])) for i in indices], ("A",))


def brief_store(path, count, budget=1000):
    """The open database of a run for one target that has some evaluations."""
    store = Store.create(path, {"targets": {"A": [1, 0, 0]}, "run": {"evaluations": budget}})
    add(store, *range(count))
    return store


@pytest.fixture
def going(start, tmp_path):
    """A run of one worker that has some evaluations, and is not at its end."""
    slow = ("--set", "simulator.pause=0.25", "--workers", 1, "--out", "run")
    with start("evolve", *STUDY, *slow, cwd=tmp_path) as process:
        try:
            wait_until(lambda: count_evaluations(tmp_path / "run") >= 5)
            yield process
        finally:
            process.kill()


def test_a_run_is_followed_to_its_end_while_others_come_and_go(start, tmp_path):
    (tmp_path / "run").mkdir()
    with ExitStack() as stack:
        with lock_run(tmp_path / "run"), brief_store(tmp_path / "run" / "run.db", 5, budget=8) as store:
            stays, leaves = (
                stack.enter_context(start("watch", "run", "--interval", 0.1, cwd=tmp_path)) for _ in range(2)
            )
            for process in (stays, leaves):
                assert process.stdout is not None
                assert process.stdout.readline().startswith("5/8 evaluations: A ")
            # To look away is no failure.
            leaves.send_signal(signal.SIGINT)
            out, err = leaves.communicate(timeout=600)
            assert (leaves.returncode, out, err) == (0, "", "")
            for index in (5, 7, 6):
                add(store, index)
                assert stays.stdout is not None
                line = stays.stdout.readline()
                assert re.match(rf"{store.count()}/8 evaluations(, \S+/s)?(, .* left)?: A 50\.00$", line), line
        out, err = stays.communicate(timeout=600)
    assert (stays.returncode, err) == (0, "")
    assert out == "finished: 8 evaluations (0 failed), best agents in run/best/\n"


@pytest.mark.long
def test_a_run_that_was_killed_has_stopped_and_its_log_is_left_to_whoever_resumes_it(going, run, tmp_path):
    going.kill()
    going.wait()
    before = sorted(path.name for path in (tmp_path / "run").glob("run.db*"))
    assert "run.db-wal" in before
    result = run("watch", "run", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    done = look(tmp_path / "run").status.done
    assert result.stdout == f"stopped after {done} of {EVALUATIONS} evaluations; resume with: driftform resume run\n"
    assert sorted(path.name for path in (tmp_path / "run").glob("run.db*")) == before


def test_what_is_told_of_a_finished_run_is_what_the_run_told(finished_run, call):
    directory, told = finished_run
    result = call("watch", directory, "--json")
    assert result.exit_code == 0, result.stderr
    document, expected = json.loads(result.stdout), json.loads(told.stdout)
    assert (document["state"], document["evaluations"], document["budget"]) == ("finished", 20, 20)
    with Store.open(directory / "run.db", read_only=True) as store:
        for name, target in document["targets"].items():
            best = expected["targets"][name]
            assert (target["evaluation"], target["fitness"]) == store.find_best(name)
            assert (target["fitness"], target["error_percent"]) == (best["fitness"], best["error_percent"])
            # One generation of ten for each target.
            own = [r for r in store.read_records((name,)) if r.candidate.target == name]
            assert target["mean_fitness"] == pytest.approx(sum(float(r.evaluation.fitness[0]) for r in own) / 10)
            assert target["generation"] == 0


def test_once_is_a_table_and_nothing_in_the_run_has_changed(run_copy, call):
    before = {path: (path.stat().st_mtime_ns, path.stat().st_size) for path in run_copy.rglob("*")}
    result = call("watch", run_copy, "--once")
    assert result.exit_code == 0, result.stderr
    assert [line.split()[0] for line in result.stdout.splitlines()[3:5]] == ["TP1", "TP7"]
    assert "20 of 20 evaluations" in result.stdout
    measures = json.loads(call("watch", run_copy, "--json").stdout)["targets"]["TP1"]["measures"]
    assert f"TP1: mass {measures['mass']:.4g}, length {measures['length']:.4g}, " in result.stdout
    assert {path: (path.stat().st_mtime_ns, path.stat().st_size) for path in run_copy.rglob("*")} == before


def test_a_run_is_watched_without_the_plugins_that_it_needs(run_copy, call):
    with Store.open(run_copy / "run.db") as store:
        study = store.read_study()
        store.write_facts("study", {**study, "simulator": {"use": "nowhere-installed"}})
    assert call("resume", run_copy).exit_code == 2
    assert call("watch", run_copy, "--once").exit_code == 0


def test_nothing_is_read_twice_but_what_lies_behind_a_gap(tmp_path, monkeypatch):
    read = []
    original = Store.read_summaries

    def counting(self, targets, first=0):
        for brief in original(self, targets, first):
            read.append(brief.index)
            yield brief

    monkeypatch.setattr(Store, "read_summaries", counting)
    with brief_store(tmp_path / "run.db", 500) as store:
        monitor = look(tmp_path)
        assert len(read) == 500
        read.clear()
        monitor.poll()
        assert read == []
        add(store, 500, 503)
        monitor.poll()
        assert read == [500, 503]
        read.clear()
        add(store, 502, 501)
        monitor.poll()
        assert read == [501, 502, 503]
        read.clear()
        monitor.poll()
        assert read == []
        assert monitor.status.done == 504 == store.count()


def test_a_larger_budget_shows_while_one_looks_on(tmp_path):
    with brief_store(tmp_path / "run.db", 5) as store, lock_run(tmp_path):
        monitor = look(tmp_path)
        assert (monitor.state, monitor.status.budget) == ("running", 1000)
        store.write_facts("study", {**store.read_study(), "run": {"evaluations": 5}})
        monitor.poll()
        assert (monitor.state, monitor.status.budget) == ("writing the best agents", 5)
    monitor.poll()
    assert monitor.state == "finished"


def test_a_writer_that_begins_is_never_refused_for_those_who_look_whether_it_has(tmp_path):
    (tmp_path / ".lock").touch()
    over = threading.Event()

    def asking():
        while not over.is_set():
            is_worked_on(tmp_path)

    monitors = [threading.Thread(target=asking) for _ in range(2)]
    for thread in monitors:
        thread.start()
    try:
        for _ in range(50):
            with lock_run(tmp_path):
                pass
    finally:
        over.set()
        for thread in monitors:
            thread.join()


def test_a_writer_ends_and_begins_as_it_likes_while_others_read(tmp_path):
    brief_store(tmp_path / "run.db", 100).close()
    over = threading.Event()
    looks, trouble, took = [], [], []

    def looking():
        while not over.is_set():
            try:
                looks.append(look(tmp_path).status.done)
            except Exception as error:
                trouble.append(error)

    monitor = threading.Thread(target=looking)
    monitor.start()
    try:
        for index in range(100, 120):
            with Store.open(tmp_path / "run.db") as store:
                began = time.monotonic()
                add(store, index)
            took.append(time.monotonic() - began)
    finally:
        over.set()
        monitor.join()
    assert trouble == []
    # Half of them: other work on the machine delays some.
    assert sorted(took)[10] < 4
    assert looks and looks == sorted(looks)
    assert look(tmp_path).status.done == 120


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
def test_on_a_terminal_the_last_picture_stays(finished_run):
    process, ours = start_on_terminal("watch", str(finished_run[0]), width=100)
    text = read_until(ours, lambda text: False)
    os.close(ours)
    assert process.wait(timeout=600) == 0
    assert "TP7" in text and "20 of 20 evaluations" in text
    assert "finished: 20 evaluations" in text
