"""No change of an operator or a constant in the core formulas goes unnoticed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).parents[1] / "mutations.py"


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="mutants run in forks")
def test_no_mutant_of_the_core_formulas_lives() -> None:
    ended = subprocess.run([sys.executable, PROGRAM, "--count", "60"], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr
