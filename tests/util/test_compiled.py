"""The cache of compiled kernels."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from filelock import FileLock

import driftform
from driftform.util import kernel_cache

SCRIPT = """
from driftform.motion.forces.buoyancy import slice_depth
still = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
print(slice_depth(0.1, still, 0.5, (0.0, 0.0, 0.02), 1.0))
"""


@pytest.fixture
def package(tmp_path):
    """A copy of driftform, which may be changed."""
    folder = tmp_path / "driftform"
    return shutil.copytree(Path(driftform.__file__).parent, folder, ignore=shutil.ignore_patterns("__pycache__"))


@pytest.fixture
def cache(tmp_path):
    """An empty cache, but for the result of the test of the compiler, which takes longer than a kernel."""
    folder = tmp_path / "cache"
    folder.mkdir()
    for result in kernel_cache.BASE.glob("kernels-*.tested"):
        shutil.copy(result, folder)
    return folder


def run_script(cache, script, timeout=None, **variables):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache), **variables}
    command = [sys.executable, "-c", script]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=timeout)


def run_kernel(cache, script=SCRIPT, timeout=None, factor=1.0, **variables):
    """Run the script, whose product of vectors may have a factor, and return what it says on stderr."""
    done = run_script(cache, script, timeout, **variables)
    assert abs(float(done.stdout) - (1.0 - 0.1 - factor * 0.02)) < 1e-12
    return done.stderr


@pytest.mark.long
@pytest.mark.parametrize("compiler", ["", "plain"])
def test_a_kernel_is_recompiled_when_a_file_changes_whose_functions_it_calls(tmp_path, cache, package, compiler):
    variables = {"DRIFTFORM_COMPILER": compiler, "PYTHONPATH": str(tmp_path)}
    run_kernel(cache, **variables)
    cached = len(list(cache.rglob("*.nbc")))
    assert cached > 0
    run_kernel(cache, **variables)
    assert len(list(cache.rglob("*.nbc"))) == cached, "the cache was not used"
    vectors = package / "util" / "small_vectors.py"
    text = vectors.read_text(encoding="utf-8")
    product = "a[0] * b[0] + a[1] * b[1] + a[2] * b[2]"
    assert text.count(product) == 1
    vectors.write_text(text.replace(product, f"3.0 * ({product})"), encoding="utf-8")
    run_kernel(cache, factor=3.0, **variables)


def test_a_compiler_that_does_not_suit_numba_is_replaced_by_that_of_numba_with_one_line_once(tmp_path, cache, package):
    compiler = package / "util" / "compiler.py"
    text = compiler.read_text(encoding="utf-8")
    variables = {"PYTHONPATH": str(tmp_path)}
    assert run_kernel(cache, **variables).count("\n") == 1, "the compilation is announced, and nothing else"
    compiler.write_text(text.replace("from numba.core.caching", "from numba.core.cached"), encoding="utf-8")
    notice, announcement = run_kernel(tmp_path / "new", **variables).splitlines()
    assert notice.startswith("kernels are compiled by numba's own compiler, for slower flights")
    assert notice.endswith("(ModuleNotFoundError: No module named 'numba.core.cached')")
    assert announcement.startswith("compiling the equations of motion")
    assert run_kernel(tmp_path / "new", **variables) == ""


def test_copies_of_the_same_sources_share_their_machine_code(tmp_path, cache, package):
    def list_times():
        return {file: file.stat().st_mtime_ns for file in cache.rglob("*.nb[ci]")}

    run_kernel(cache)
    before = list_times()
    assert before
    run_kernel(cache, PYTHONPATH=str(tmp_path))
    assert list_times() == before


def test_machine_code_is_removed_when_no_process_has_used_it_for_a_month(tmp_path, monkeypatch):
    monkeypatch.setattr(kernel_cache, "BASE", tmp_path)
    used = kernel_cache.find_folder("linked")
    folders = [tmp_path / "kernels-linked-old", tmp_path / "kernels-linked-recent", used]
    for folder in folders:
        folder.mkdir()
    for folder in (folders[0], used):
        os.utime(folder, (0, 0))
    assert kernel_cache.find_folder("linked") == used
    kernel_cache.find_folder("another")
    assert [folder.exists() for folder in folders] == [False, True, True]


@pytest.mark.skipif(not hasattr(os, "setsid"), reason="no sessions of processes")
def test_a_compilation_is_announced_once_to_the_processes_of_a_run_and_again_to_another_run(tmp_path):
    command = [sys.executable, "-c", "from driftform.util.kernel_cache import announce; announce(9)"]

    def announce(**options):
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True, **options).stderr

    assert announce() == (
        "compiling the equations of motion for this kind of flight, about 9 s; later runs load the result\n"
    )
    assert announce() == ""
    # The studio's server may have compiled something; a search that it begins is a session of its own.
    assert announce(start_new_session=True).startswith("compiling")


@pytest.mark.parametrize(
    ("fault", "notice"),
    [("1e-15 + ", "new machine code gives other numbers than Python"), ("os.abort() or ", "exit code -")],
)
def test_a_compiler_whose_code_gives_other_numbers_or_ends_the_process_does_not_pass_its_test(
    tmp_path, package, fault, notice
):
    check = package / "util" / "compiler_check.py"
    text = check.read_text(encoding="utf-8")
    changed = text.replace("if _kernel(*_arguments)", f"if ({fault}_kernel(*_arguments))")
    check.write_text(changed.replace("import math\n", "import math\nimport os\n"), encoding="utf-8")
    first, _ = run_kernel(tmp_path / "cache", PYTHONPATH=str(tmp_path)).splitlines()
    assert notice in first


def test_an_unknown_compiler_is_refused(tmp_path):
    environment = {**os.environ, "DRIFTFORM_COMPILER": "fast"}
    app = "from driftform.cli import main; main()"
    command = [sys.executable, "-c", app, "evolve", "--evaluations", "1", "--out", str(tmp_path / "run")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "Traceback" not in done.stderr
    assert done.stderr.endswith("DRIFTFORM_COMPILER: unknown compiler 'fast'; set it to 'plain', or unset it\n")


def test_without_a_directory_to_write_to_kernels_are_compiled_without_a_cache(tmp_path):
    (tmp_path / "file").touch()
    run_kernel(tmp_path / "file" / "cache")


def test_a_damaged_cache_is_begun_anew_with_one_line(cache):
    run_kernel(cache)
    [index], [code] = (list(cache.rglob(f"buoyancy.*.{end}")) for end in ("nbi", "nbc"))
    sound = code.read_bytes()
    altered = sound[:2000] + bytes([sound[2000] ^ 1]) + sound[2001:]
    for file, data in ((index, index.read_bytes()[:7]), (index, b"text"), (code, sound[:7]), (code, altered)):
        file.write_bytes(data)
        said = run_kernel(cache)
        assert said.startswith(f"{index} is damaged (") and said.count("\n") == 1
        assert run_kernel(cache) == ""


def test_processes_compile_one_kernel_for_different_types_at_the_same_time(cache):
    run_kernel(cache)
    [types] = cache.rglob("slice_depth-*.lock")
    for file in cache.rglob("*.nb[ci]"):
        file.unlink()
    with FileLock(types):
        run_kernel(cache, SCRIPT.replace("0.02), 1.0", "0.02), 1"))
        with pytest.raises(subprocess.TimeoutExpired):
            run_kernel(cache, timeout=4)
    run_kernel(cache)
    assert len(list(cache.rglob("buoyancy.slice_depth-*.nbc"))) == 2


@pytest.mark.parametrize("enters", [True, False])
@pytest.mark.parametrize("fails", ["returns", "receives"])
def test_a_kernel_that_counts_no_references_and_gets_hold_of_an_array_is_refused(fails, enters):
    import numpy as np

    from driftform.util.compiled import allocating, compiled

    @allocating
    def make(size):
        return np.zeros(size)

    @compiled
    def returns(values):
        return values

    @compiled
    def receives(values):
        return make(len(values))[0]

    part = {"returns": returns, "receives": receives}[fails]

    @allocating
    def enter(values):
        part(values)
        return len(values)

    with pytest.raises(Exception, match=f"{fails}: a kernel that returns or receives new arrays must be @allocating"):
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
    assert int(run_script(kernel_cache.BASE, script).stdout) == 0


CALLER = """
from driftform.util.compiled import compiled


def enter(depth):
    @compiled
    def call(value):
        return slice_depth(0.1, still, 0.5, (0.0, 0.0, 0.02), 1.0) + value - value

    return call(depth)
"""


@pytest.mark.long
def test_a_kernel_from_the_cache_holds_machine_code_only_and_other_kernels_can_call_it(cache):
    run_kernel(cache)
    [file] = cache.rglob("buoyancy.*.nbc")
    assert file.stat().st_size < 16_384, "the file holds more than the machine code of an entry"
    used = "from driftform.motion.forces.buoyancy import slice_depth\n"
    script = SCRIPT.replace("print(", "first = (").replace(used, used + CALLER) + "print(enter(first))"
    run_kernel(cache, script)
    [same] = cache.rglob("buoyancy.slice_depth-*.nbc")
    assert same == file


SPACED = """
import sys
import numpy as np
from numba.core.runtime.nrt import rtsys
from driftform.motion.path.thinning import select_spaced
spaced = select_spaced(np.arange(5.0), 2.0).tolist()
print(spaced, "numba.np.arrayobj" in sys.modules, rtsys._init)
"""


@pytest.mark.long
def test_loading_a_kernel_that_makes_arrays_neither_compiles_nor_imports_what_its_compilation_needs(cache):
    printed = [run_script(cache, SPACED).stdout for _ in ("compiled", "loaded")]
    assert printed == ["[0, 2, 4] True True\n", "[0, 2, 4] False False\n"]
