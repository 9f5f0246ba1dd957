"""Runs that are killed, interrupted, watched and fought over: nothing stored is lost, and the result is the same."""

import json
import os
import signal
import sqlite3
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from processes import count_evaluations, is_alive, make_arguments, wait_until

pytestmark = [pytest.mark.long, pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")]

EVALUATIONS = 60
STUDY = make_arguments(EVALUATIONS)
# Long enough that a run is not at its end when a busy machine comes to interrupt it.
PAUSE = 0.15


def children(process):
    """Processes that a process started, and theirs, as the kernel has them."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                status = (entry / "stat").read_text()
            except OSError:
                continue
            state, parent = status.rpartition(")")[2].split()[:2]
            if int(parent) == process and state != "Z":
                found += [int(entry.name), *children(int(entry.name))]
    return found


def workers(process):
    """Those of its processes that evaluate: not the one that watches over shared resources."""
    found = []
    for child in children(process):
        with suppress(OSError):  # it may have ended since
            if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
                found.append(child)
    return found


needs_proc = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads /proc")


@pytest.fixture(scope="module")
def undisturbed(run, rows, tmp_path_factory):
    cwd = tmp_path_factory.mktemp("undisturbed")
    result = run("evolve", *STUDY, "--set", f"simulator.pause={PAUSE}", "--workers", 2, "--out", "run", cwd=cwd)
    assert result.returncode == 0, result.stderr
    return rows(cwd / "run")


@pytest.fixture(autouse=True)
def hangups():
    """Programs that a test starts hear SIGHUP, though whoever started the tests may ignore it, as ``nohup`` does."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture
def going(start, tmp_path, request):
    """A run of two workers that has some evaluations, and is not at its end."""
    more = ("--set", f"simulator.pause={getattr(request, 'param', PAUSE)}", "--workers", 2, "--out", "run")
    with start("evolve", *STUDY, *more, cwd=tmp_path) as process:
        try:
            wait_until(lambda: count_evaluations(tmp_path / "run") >= 15)
            yield process
        finally:
            process.kill()


@needs_proc
def test_killed_it_leaves_no_workers_and_is_resumed_to_the_same_result(going, run, rows, undisturbed, tmp_path):
    started = workers(going.pid)
    assert started
    going.kill()
    going.wait()
    wait_until(lambda: not any(is_alive(worker) for worker in started))
    assert 15 <= count_evaluations(tmp_path / "run") < EVALUATIONS

    resumed = run("resume", "run", "--workers", 1, "--json", cwd=tmp_path)
    assert resumed.returncode == 0, resumed.stderr
    assert json.loads(resumed.stdout)["evaluations"] == EVALUATIONS
    assert rows(tmp_path / "run") == undisturbed


@needs_proc
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interrupted_it_names_the_command_that_goes_on_and_leaves_the_database_whole(
    going, run, rows, undisturbed, tmp_path, number
):
    started = children(going.pid)
    going.send_signal(number)
    out, err = going.communicate(timeout=600)
    assert going.returncode == 128 + number
    assert out == ""
    assert "Traceback" not in err
    last = err.splitlines()[-1]
    assert last.startswith("stopped after ")
    assert last.endswith("resume with: driftform resume run")
    wait_until(lambda: not any(is_alive(child) for child in started))
    # Whole, and in one file: what is copied is all there is.
    assert sorted(path.name for path in (tmp_path / "run").glob("run.db*")) == ["run.db"]
    connection = sqlite3.connect(tmp_path / "run" / "run.db")
    assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    connection.close()

    assert run(*last.partition("driftform ")[2].split(), cwd=tmp_path).returncode == 0
    assert rows(tmp_path / "run") == undisturbed


@needs_proc
@pytest.mark.parametrize("delay", [0.0, 0.2, 2.0], ids=["workers start", "workers import", "workers fly"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_ended_it_does_not_wait_for_long_flights_and_leaves_no_process(start, tmp_path, number, delay):
    args = ("evolve", *STUDY, "--set", "simulator.pause=6000", "--workers", 2)
    with start(*args, "--out", "run", cwd=tmp_path) as process:
        wait_until(lambda: (tmp_path / "run" / "run.db").exists() and len(workers(process.pid)) == 2)
        time.sleep(delay)
        started = children(process.pid)
        # Ctrl-C of a terminal reaches all of them.
        for child in [process.pid, *(workers(process.pid) if number == signal.SIGINT else [])]:
            os.kill(child, number)
        _, err = process.communicate(timeout=600)
    assert "Traceback" not in err
    if number == signal.SIGINT:
        assert process.returncode == 130
        last = err.splitlines()[-1]
        # Its database is there a moment before the run is one that can be named.
        assert last.startswith(f"stopped after 0 of {EVALUATIONS} evaluations") or (not delay and last == "interrupted")
    wait_until(lambda: not any(map(is_alive, started)))


@pytest.mark.parametrize("going", [1.5], ids=["slow"], indirect=True)
def test_a_second_process_on_a_run_is_refused(going, run, tmp_path):
    for args in (("resume", "run"), ("evolve", *STUDY, "--out", "run")):
        second = run(*args, cwd=tmp_path)
        assert second.returncode == 2
        assert second.stdout == ""
        [line] = second.stderr.splitlines()
        assert line.startswith("error: run")
    assert going.poll() is None


def test_the_best_so_far_is_read_while_the_run_goes_on(going, run, rows, undisturbed, tmp_path):
    read = run("inspect", "run:TP1", "--json", cwd=tmp_path)
    assert read.returncode == 0, read.stderr
    _, err = going.communicate(timeout=600)
    assert going.returncode == 0, err
    assert rows(tmp_path / "run") == undisturbed


def test_resuming_a_finished_run_changes_nothing(run_copy, call, rows):
    before = rows(run_copy)
    files = {path: path.read_bytes() for path in run_copy.rglob("*") if path.is_file()}
    result = call("resume", run_copy, "--workers", 1, "--json")
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["evaluations"] == 20
    assert rows(run_copy) == before
    after = {path: path.read_bytes() for path in run_copy.rglob("*") if path.is_file()}
    assert after.keys() == files.keys()
    assert [path.name for path in files if files[path] != after[path] and path.name != "run.db"] == []
