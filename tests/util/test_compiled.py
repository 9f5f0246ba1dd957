"""The cache of compiled kernels."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from filelock import FileLock

import driftform

SCRIPT = """
from driftform.motion.buoyancy import slice_depth
still = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
print(slice_depth(0.1, still, 0.5, (0.0, 0.0, 0.02), 1.0))
"""


@pytest.mark.long
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


def run_kernel(cache, script=SCRIPT, timeout=None):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=timeout,
    )
    assert done.returncode == 0, done.stderr
    assert abs(float(done.stdout) - (1.0 - 0.1 - 0.02)) < 1e-12


def test_without_a_directory_to_write_to_kernels_are_compiled_without_a_cache(tmp_path):
    (tmp_path / "file").touch()
    run_kernel(tmp_path / "file" / "cache")


def test_a_cache_that_was_cut_short_is_begun_anew(tmp_path):
    run_kernel(tmp_path)
    files = [*tmp_path.rglob("*.nbi"), *tmp_path.rglob("*.nbc")]
    assert len(files) >= 2
    for file in files:
        os.truncate(file, 7)
    run_kernel(tmp_path)
    assert all(file.stat().st_size > 7 for file in tmp_path.rglob("*.nbi"))


def test_processes_compile_one_kernel_for_different_types_at_the_same_time(tmp_path):
    run_kernel(tmp_path)
    [types] = tmp_path.rglob("slice_depth-*.lock")
    for file in tmp_path.rglob("*.nb[ci]"):
        file.unlink()
    with FileLock(types):
        run_kernel(tmp_path, SCRIPT.replace("0.02), 1.0", "0.02), 1"))
        with pytest.raises(subprocess.TimeoutExpired):
            run_kernel(tmp_path, timeout=4)
    run_kernel(tmp_path)
    assert len(list(tmp_path.rglob("buoyancy.slice_depth-*.nbc"))) == 2


def test_numba_is_left_as_it_was_after_a_kernel_is_compiled():
    from numba.core.types.functions import BaseFunction

    from driftform.util.compiled import compiled

    resolve = BaseFunction.get_call_type

    @compiled
    def add(a: float, b: float) -> float:
        return a + b

    assert add(1.0, 2.0) == 3.0 and BaseFunction.get_call_type is resolve

    @compiled
    def fail(a: str) -> float:
        return a.nothing

    with pytest.raises(Exception, match="nothing"):
        fail("x")
    assert BaseFunction.get_call_type is resolve


@pytest.mark.parametrize("enters", [True, False])
@pytest.mark.parametrize("fails", ["returns", "receives"])
def test_a_kernel_that_counts_no_references_and_gets_hold_of_an_array_is_refused(fails, enters):
    import numpy as np

    from driftform.util.compiled import allocating, compiled

    @allocating
    def make(size: int) -> np.ndarray:
        return np.zeros(size)

    @compiled
    def returns(values: np.ndarray) -> np.ndarray:
        return values

    @compiled
    def receives(values: np.ndarray) -> float:
        return make(len(values))[0]

    part = {"returns": returns, "receives": receives}[fails]

    @allocating
    def enter(values: np.ndarray) -> int:
        part(values)
        return len(values)

    with pytest.raises(
        Exception, match=f"{fails}: a kernel that returns or receives new arrays must be @allocating"
    ):
        (enter if enters else part)(np.ones(3))


FLIGHTS = """
import gc

import numpy as np
from numba.core.runtime import _nrt_python, rtsys

from driftform.study import load_study

_nrt_python.memsys_enable_stats()
study = load_study("SCENARIO", settings=['flow.kind="KIND"'], use={"simulator": "native"}, run={"seed": 0})
pipeline, rng = study.make_pipeline(), np.random.default_rng(0)
genomes = [pipeline.grammar.random(rng) for _ in range(8)]


def count_arrays():
    for evaluation in pipeline.evaluate(genomes, [None] * 8, [None] * 8):
        assert evaluation.failure is None, evaluation.failure
    gc.collect()
    stats = rtsys.get_allocation_stats()
    assert stats.alloc > 0
    return stats.alloc - stats.free


first = count_arrays()
print(count_arrays() - first)
"""


@pytest.mark.long
@pytest.mark.parametrize(("scenario", "kind"), [("paper", "uniform"), ("pipe-inspection", "turbulent")])
def test_flights_leave_no_array_behind_in_memory(scenario, kind):
    script = FLIGHTS.replace("SCENARIO", scenario).replace("KIND", kind)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert int(done.stdout) == 0


CALLER = """
from driftform.util.compiled import compiled


def enter(depth):
    @compiled
    def call(value):
        return slice_depth(0.1, still, 0.5, (0.0, 0.0, 0.02), 1.0) + value - value

    return call(depth)
"""


@pytest.mark.long
def test_a_kernel_from_the_cache_holds_machine_code_only_and_other_kernels_can_call_it(tmp_path):
    run_kernel(tmp_path)
    [file] = tmp_path.rglob("*.nbc")
    assert file.stat().st_size < 16_384, "the file holds more than the machine code of an entry"
    used = "from driftform.motion.buoyancy import slice_depth\n"
    script = SCRIPT.replace("print(", "first = (").replace(used, used + CALLER) + "print(enter(first))"
    run_kernel(tmp_path, script)
    [same] = tmp_path.rglob("buoyancy.slice_depth-*.nbc")
    assert same == file


SPACED = """
import sys
import numpy as np
from numba.core.runtime.nrt import rtsys
from driftform.motion.resampling import select_spaced
spaced = select_spaced(np.arange(5.0), 2.0).tolist()
print(spaced, sorted({"numba.np.arrayobj", "numpy.ma"} & set(sys.modules)), rtsys._init)
"""


@pytest.mark.long
def test_loading_a_kernel_that_makes_arrays_neither_compiles_nor_imports_what_its_compilation_needs(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", SPACED]
    printed = [
        subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
        for _ in ("compiled", "loaded")
    ]
    assert printed == ["[0, 2, 4] ['numba.np.arrayobj', 'numpy.ma'] True\n", "[0, 2, 4] [] False\n"]
