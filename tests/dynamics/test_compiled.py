"""The cache of compiled kernels."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import driftform

SCRIPT = """
import numpy as np
from driftform.dynamics.equations import body_forces
pipe = np.array([[0.0, 0, 0, 9, 0, 0, 1.0]])
rims = np.array([[0.0, 0.02, 1000.0, 20.0]])
tau = np.zeros(6)
down = np.array([2.0, 0, 0.981]), np.eye(3), np.array([0.0, 0, 0.1]), np.zeros(3), np.zeros(6)
body_forces(*down, np.zeros((28, 6)), rims, pipe, tau)
print(tau[2])
"""


def test_a_kernel_is_compiled_anew_when_a_file_changes_that_it_only_calls_into(tmp_path):
    package = Path(driftform.__file__).parent
    shutil.copytree(package, tmp_path / "driftform", ignore=shutil.ignore_patterns("__pycache__"))
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def force():
        command = [sys.executable, "-c", SCRIPT]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return float(done.stdout)

    spring, damper = 1000 * 1e-3, 20 * 0.1
    assert abs(force() + spring + damper) < 1e-3
    cached = len(list((tmp_path / "cache").rglob("*.nbc")))
    assert cached > 0
    assert abs(force() + spring + damper) < 1e-3
    assert len(list((tmp_path / "cache").rglob("*.nbc"))) == cached, "the cache was not used"
    contact = tmp_path / "driftform" / "dynamics" / "contact.py"
    text = contact.read_text(encoding="utf-8")
    assert "ONSET = 1e-3" in text
    contact.write_text(text.replace("ONSET = 1e-3", "ONSET = 1e-2"), encoding="utf-8")
    assert abs(force() + spring + damper / 10) < 1e-3
