"""No change of an operator or a constant in the core formulas goes unnoticed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).parents[1] / "mutations.py"


def test_each_chosen_change_has_its_place_and_its_tests():
    listed = subprocess.run(
        [sys.executable, PROGRAM, "--chosen", "--list"], capture_output=True, text=True, check=False
    )
    assert listed.returncode == 0, f"tests/mutants.toml is out of date: {listed.stderr}"


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="mutants run in forks")
def test_no_mutant_of_the_core_formulas_lives():
    ended = subprocess.run([sys.executable, PROGRAM, "--count", "60"], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr
