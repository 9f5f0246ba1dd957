"""The first second: Ctrl-C while modules are imported, streams that are closed, and a cache that cannot be written to."""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from driftform.util import kernel_cache

pytestmark = pytest.mark.long
posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has neither such signals nor such limits")

INTERRUPTED = """
import os, signal, sys

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupt())
"""

RUN = ("paper", "--target", "TP1", "--evaluations", 12, "--seed", 1, "--workers", 1, "--simulator", "fake")


@posix
@pytest.mark.parametrize("name", ["typer", "driftform.cli.help", "numpy", "driftform.study.study"])
def test_an_interruption_while_modules_are_imported_is_one_line(tmp_path: Path, fake_plugin: Path, name: str) -> None:
    # Python runs this module before the program.
    (tmp_path / "sitecustomize.py").write_text(INTERRUPTED.format(name=name), encoding="utf-8")
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
def test_a_run_whose_streams_are_closed_is_that_of_open_ones(
    tmp_path: Path, fake_plugin: Path, rows: Callable[[Path], list[tuple[object, ...]]], streams: str
) -> None:
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


def test_a_cache_that_cannot_be_written_names_the_variable_that_moves_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
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


def test_an_announcement_from_the_future_does_not_silence_this_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(kernel_cache, "BASE", tmp_path)
    kernel_cache.announce.__wrapped__(15)
    # The clock has jumped back since.
    os.utime(tmp_path / "kernels.announced", (time.time() + 1e6, time.time() + 1e6))
    kernel_cache.announce.__wrapped__(15)
    kernel_cache.announce.__wrapped__(15)
    assert capsys.readouterr().err.count("compiling the equations of motion") == 2
