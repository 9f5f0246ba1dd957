"""``--help`` and ``--version``; and readers that stop reading."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import driftform

Call = Callable[..., Any]


def test_help_and_version(call: Call) -> None:
    assert call("--version").stdout == f"driftform {driftform.__version__}\n"
    for args in ((), ("evolve",), ("plugins", "show")):
        assert "Usage" in call(*args, "--help").stdout
    assert "Usage" in call().output


@pytest.mark.skipif(sys.platform == "win32", reason="closes a POSIX pipe")
@pytest.mark.parametrize("args", [("plugins",), ("scenarios", "show", "pipe-inspection"), ("--help",)])
def test_a_reader_that_stops_early_sees_no_traceback(
    start: Callable[..., subprocess.Popen[str]], tmp_path: Path, args: tuple[str, ...]
) -> None:
    with start(*args, cwd=tmp_path) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == ""
