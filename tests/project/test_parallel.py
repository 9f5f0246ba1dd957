"""The whole suite runs in parallel; what is slow, names single files or writes pages does not."""

import importlib.util
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def hooks() -> ModuleType:
    spec = importlib.util.spec_from_file_location("session_hooks", ROOT / "tests" / "conftest.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("args", "markexpr", "update", "workers"),
    [
        (["tests", "plugins"], None, "", 6),
        (["tests/motion"], None, "", 6),
        (["tests/project/test_parallel.py"], None, "", 0),
        (["tests/project/test_parallel.py::test_a"], None, "", 0),
        (["tests", "plugins"], "slow", "", 0),
        (["tests", "plugins"], "installs", "", 0),
        (["tests", "plugins"], None, "1", 0),
    ],
)
def test_the_default_selection_of_folders_takes_all_cores(
    hooks: ModuleType,
    pytestconfig: pytest.Config,
    monkeypatch: pytest.MonkeyPatch,
    args: list[str],
    markexpr: str | None,
    update: str,
    workers: int,
) -> None:
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr("os.cpu_count", lambda: 6)
    monkeypatch.setenv("UPDATE_DOCS", update)
    [usual] = [word for word in pytestconfig.getini("addopts") if word.startswith("not slow")]
    config = SimpleNamespace(args=args, option=SimpleNamespace(markexpr=markexpr or usual), getini=pytestconfig.getini)
    assert hooks.pytest_xdist_auto_num_workers(config) == workers


@pytest.mark.parametrize("simulator", ["native", "exudyn"])
def test_the_kernels_that_are_compiled_before_the_workers_start_are_those_of_real_flights(
    hooks: ModuleType, monkeypatch: pytest.MonkeyPatch, simulator: str
) -> None:
    monkeypatch.setattr("sys.argv", ["kernels", simulator, str(ROOT / "tests" / "helpers")])
    exec(compile(hooks.KERNELS, "kernels", "exec"), {})
