"""The first second and the last kilobyte: Ctrl-C while modules are imported, closed streams, full disks, no home, and clocks that jump."""

import itertools
import os
import sqlite3
import subprocess
import sys
import sysconfig
import time
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from driftform.search.local import InProcess
from driftform.study import Document, load_study
from driftform.util import kernel_cache

pytestmark = pytest.mark.long
posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has neither such signals nor such limits")

INTERRUPTED = """
import ctypes, os, signal, sys

def send():
    os.kill(os.getpid(), signal.SIGINT)

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            {call}()

sys.meta_path.insert(0, Interrupt())
"""

RUN = ("paper", "--target", "TP1", "--evaluations", 12, "--seed", 1, "--workers", 1, "--simulator", "fake")


@posix
@pytest.mark.parametrize("name", ["typer", "driftform.cli.help", "numpy", "driftform.study.study"])
@pytest.mark.parametrize("call", ["send", "ctypes.CFUNCTYPE(None)(send)"], ids=["by Python", "by a library's callback"])
def test_an_interruption_while_modules_are_imported_is_one_line(tmp_path, fake_plugin, name, call):
    # Python runs this module before the program.
    (tmp_path / "sitecustomize.py").write_text(INTERRUPTED.format(name=name, call=call), encoding="utf-8")
    command = [str(Path(sys.executable).with_name("driftform")), "evolve", *map(str, RUN), "--out", "run"]
    path = os.pathsep.join(map(str, (tmp_path, fake_plugin)))
    done = subprocess.run(
        command, cwd=tmp_path, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 130, done.stderr
    assert done.stdout == ""
    assert done.stderr == "interrupted\n"
    assert not (tmp_path / "run").exists()


@posix
@pytest.mark.parametrize("streams", ["1>&-", "2>&-", "0<&- 1>&- 2>&-"])
def test_a_run_whose_streams_are_closed_is_that_of_open_ones(tmp_path, fake_plugin, rows, streams):
    program = Path(sys.executable).with_name("driftform")
    for name, closed in (("open", ""), ("closed", streams)):
        command = f"'{program}' evolve {' '.join(map(str, RUN))} --out {name} {closed}"
        done = subprocess.run(
            ["/bin/sh", "-c", command],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(fake_plugin)},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            check=False,
        )
        assert done.returncode == 0 and b"Traceback" not in done.stderr, done.stderr
    assert rows(tmp_path / "closed") == rows(tmp_path / "open")


def test_a_cache_that_cannot_be_written_names_the_variable_that_moves_it(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").touch()
    monkeypatch.setattr(kernel_cache, "BASE", tmp_path / "file" / "cache")
    monkeypatch.setattr(kernel_cache, "gettempdir", lambda: str(tmp_path))
    for _ in range(2):
        kernel_cache.announce.__wrapped__(15)
    # Once, although nothing is cached.
    assert capsys.readouterr().err == (
        f"compiling the equations of motion for this kind of flight, about 15 s, at each start: {tmp_path / 'file' / 'cache'} cannot be "
        "written to; set NUMBA_CACHE_DIR to a directory that can\n"
    )


@pytest.fixture
def here(fakes, monkeypatch):
    """Evaluations are made in this process."""

    def open_here(document, *_, **__):
        return InProcess(load_study(Document("study", document)).make_pipeline())

    monkeypatch.setattr("driftform.search.executors.LocalProcesses", open_here)
    # Python does not see that a file of its own cache is cut short.
    monkeypatch.setattr(sys, "dont_write_bytecode", True)


@contextmanager
def files_of_at_most(size):
    """Let no file of this process grow beyond a size, as on a disk that is full then."""
    import resource

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


SIZES = [0, 1, 100, 512, 1024, 2048, 3000, 4096, 8192, 16_384, 30_000, 50_000, 70_000, 100_000, 150_000, 200_000]


@posix
@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    "size", [pytest.param(s, marks=() if s in (0, 4096, 8192, 100_000) else pytest.mark.slow) for s in SIZES]
)
def test_a_full_disk_is_one_line_with_a_name_and_what_it_leaves_goes_on_when_there_is_room(call, rows, tmp_path, size):
    with files_of_at_most(size):
        result = call("evolve", *RUN, "--out", "run")
    assert isinstance(result.exception, SystemExit), result.exception
    assert result.exit_code == 1, "the limit is below what the run needs"
    line = result.stderr.splitlines()[-1]
    assert line.startswith("error: run/"), line
    # An exporter says what it was told of its own file.
    assert "free the disk" in line or "File too large" in line, line
    assert "Traceback" not in result.stderr
    kept = rows(tmp_path / "run") if (tmp_path / "run" / "run.db").is_file() else []
    again = call("resume", "run", "--workers", 1)
    if again.exit_code == 2:
        assert "start it again with the same 'driftform evolve' and --out run" in again.stderr
        again = call("evolve", *RUN, "--out", "run")
    assert again.exit_code == 0, again.stderr
    found = rows(tmp_path / "run")
    assert call("evolve", *RUN, "--out", "whole").exit_code == 0
    assert found == rows(tmp_path / "whole")
    assert set(kept) <= set(found)
    assert not list((tmp_path / "run").rglob("*.part*"))
    with closing(sqlite3.connect(tmp_path / "run" / "run.db")) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)


@pytest.mark.usefixtures("here")
def test_a_clock_that_jumps_back_changes_no_result(call, rows, tmp_path, monkeypatch):
    assert call("evolve", *RUN, "--out", "whole").exit_code == 0
    hours = itertools.count()
    with monkeypatch.context() as jumping:
        jumping.setattr(time, "time", lambda: 1e9 - 3600.0 * next(hours))
        result = call("evolve", *RUN, "--out", "jumping")
        assert result.exit_code == 0, result.stderr
        assert call("watch", "jumping", "--once").exit_code == 0
        assert call("resume", "jumping", "--workers", 1).exit_code == 0
    assert rows(tmp_path / "jumping") == rows(tmp_path / "whole")


def test_without_a_home_and_a_cache_the_program_works(fake_plugin, tmp_path):
    # Below a file nobody can write, not even the superuser of a container.
    (tmp_path / "file").touch()
    names = ("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "LOCALAPPDATA", "USERPROFILE")
    nowhere = dict.fromkeys(names, str(tmp_path / "file" / "nowhere"))
    done = subprocess.run(
        [str(Path(sysconfig.get_path("scripts")) / "driftform"), "evolve", *map(str, RUN), "--out", "run"],
        cwd=tmp_path,
        env=os.environ | nowhere | {"PYTHONPATH": str(fake_plugin), "NUMBA_CACHE_DIR": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
