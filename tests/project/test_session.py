"""Which tests a session runs, and on how many cores; tests that need other packages and programs are left out by default."""

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def conftest():
    spec = importlib.util.spec_from_file_location("session_hooks", ROOT / "tests" / "conftest.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def skipped(*markers):
    longrepr = ("conftest.py", 3, "Skipped: openscad is not installed")
    return pytest.TestReport("test_a", ("a.py", 1, "a"), dict.fromkeys(markers, 1), "skipped", longrepr, "setup")


@pytest.mark.parametrize(
    ("ci", "markers", "outcome"), [("true", ["peers"], "failed"), ("", ["peers"], "skipped"), ("true", [], "skipped")]
)
def test_a_program_that_is_missing_fails_its_tests_in_ci_only(conftest, monkeypatch, ci, markers, outcome):
    monkeypatch.setenv("CI", ci)
    hook = conftest.Peers().pytest_runtest_makereport(SimpleNamespace(keywords=markers))
    next(hook)
    with pytest.raises(StopIteration) as end:
        hook.send(skipped(*markers))
    assert end.value.value.outcome == outcome
    assert "openscad is not installed" in str(end.value.value.longrepr)


@pytest.mark.parametrize(
    ("path", "optional"),
    [
        ("plugins/driftform-ribs/tests/test_contract.py", True),
        ("plugins/driftform-robotics", True),
        ("plugins/driftform-frusta/tests/test_step.py", False),
        ("tests/docs/test_site.py", False),
        ("plugins", False),
    ],
)
def test_plugins_that_the_core_does_not_install_are_peers(conftest, pytestconfig, path, optional):
    [usual] = [word for word in pytestconfig.getini("addopts") if word.startswith("not slow")]
    marks = []
    item = SimpleNamespace(path=ROOT / path, add_marker=marks.append)
    conftest.Peers().pytest_collection_modifyitems([item])
    assert marks == (["peers"] if optional else [])
    for expression, ignored in ((usual, optional), ("peers and not slow", False)):
        config = SimpleNamespace(option=SimpleNamespace(markexpr=expression))
        assert bool(conftest.Peers().pytest_ignore_collect(ROOT / path, config)) is ignored


@pytest.mark.parametrize(
    ("args", "markexpr", "update", "workers"),
    [
        (["tests", "plugins"], None, "", 6),
        (["tests/motion"], None, "", 6),
        (["tests/project/test_session.py"], None, "", 0),
        (["tests/project/test_session.py::test_a"], None, "", 0),
        (["tests", "plugins"], "slow", "", 0),
        (["tests", "plugins"], "installs", "", 0),
        (["tests", "plugins"], None, "1", 0),
    ],
)
def test_the_default_selection_of_folders_takes_all_cores(
    conftest, pytestconfig, monkeypatch, args, markexpr, update, workers
):
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr("os.cpu_count", lambda: 6)
    monkeypatch.setenv("UPDATE_DOCS", update)
    [usual] = [word for word in pytestconfig.getini("addopts") if word.startswith("not slow")]
    config = SimpleNamespace(args=args, option=SimpleNamespace(markexpr=markexpr or usual), getini=pytestconfig.getini)
    assert conftest.pytest_xdist_auto_num_workers(config) == workers


@pytest.mark.parametrize("simulator", ["native", pytest.param("exudyn", marks=pytest.mark.long)])
def test_the_kernels_that_are_compiled_before_the_workers_start_are_those_of_real_flights(
    conftest, monkeypatch, simulator
):
    monkeypatch.setattr("sys.argv", ["kernels", simulator, str(ROOT / "tests" / "helpers")])
    exec(compile(conftest.KERNELS, "kernels", "exec"), {})
