"""The cache of compiled kernels."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import driftform

SCRIPT = """
from driftform.dynamics.buoyancy import slice_depth
still = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
print(slice_depth(0.1, still, 0.5, (0.0, 0.0, 0.02), 1.0))
"""


def test_a_kernel_is_recompiled_when_a_file_changes_whose_functions_it_calls(tmp_path):
    package = Path(driftform.__file__).parent
    shutil.copytree(package, tmp_path / "driftform", ignore=shutil.ignore_patterns("__pycache__"))
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def depth():
        command = [sys.executable, "-c", SCRIPT]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return float(done.stdout)

    assert abs(depth() - (1.0 - 0.1 - 0.02)) < 1e-12
    cached = len(list((tmp_path / "cache").rglob("*.nbc")))
    assert cached > 0
    assert abs(depth() - (1.0 - 0.1 - 0.02)) < 1e-12
    assert len(list((tmp_path / "cache").rglob("*.nbc"))) == cached, "the cache was not used"
    vectors = tmp_path / "driftform" / "dynamics" / "vectors.py"
    text = vectors.read_text(encoding="utf-8")
    product = "a[0] * b[0] + a[1] * b[1] + a[2] * b[2]"
    assert text.count(product) == 1
    vectors.write_text(text.replace(product, f"3.0 * ({product})"), encoding="utf-8")
    assert abs(depth() - (1.0 - 0.1 - 3 * 0.02)) < 1e-12
