"""What tests share: the program, a plugin that does harm, finished runs, the tables of docs, and how many to take."""

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import sysconfig
import time
import tomllib
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from chromium import browser
from filelock import FileLock
from pages import publish, published, up_to_date
from program import call, ideal_water, install, refused, write_metadata
from shared import shared_folder

from driftform.util.files import cache_folder

__all__ = ["browser", "call", "ideal_water", "install", "publish", "published", "refused", "up_to_date"]

MAX_WORKERS = 8

PEER_FIXTURES = {"browser", "dask", "requires_program", "site"}
"""Fixtures that need what the default environment does not have: their tests are of the group ``peers``."""

KERNELS = """
import sys

import numpy as np

from driftform.study import load_study
sys.path.insert(0, sys.argv[2])
from textbook import distance_from_textbook, random_case

for name in ("paper", "pipe-inspection"):
    pipeline = load_study(name, use={"simulator": sys.argv[1]}, run={"seed": 0}).make_pipeline()
    genome = pipeline.grammar.random(np.random.default_rng(0))
    pipeline.simulator.simulate(pipeline.make_agent(genome), pipeline.scenario)
agent, scenario = random_case(0, 0.1)
distance_from_textbook(pipeline.simulator.simulate(agent, scenario), agent, scenario, 0.1)
"""

ROOT = Path(__file__).parents[1]
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROGRAM = Path(sysconfig.get_path("scripts")) / ("driftform.exe" if os.name == "nt" else "driftform")


def pytest_xdist_auto_num_workers(config):
    """Return a worker for each core, or 0 (one process) for single files, slow tests, and tests that write pages."""
    folders = any(Path(name).is_dir() for name in config.args)
    if not folders or "not slow" not in config.option.markexpr or os.environ.get("UPDATE_DOCS") == "1":
        return 0
    return min(MAX_WORKERS, os.cpu_count() or 1)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes():
    """Compile the kernels before the workers start, so that no test waits for them."""
    command = (sys.executable, "-c", KERNELS)
    processes = [
        subprocess.Popen([*command, simulator, str(ROOT / "tests" / "helpers")]) for simulator in ("native", "exudyn")
    ]
    assert [process.wait() for process in processes] == [0, 0]


class Peers:
    """What holds for tests of ``peers``, also for those of plugins, which hooks of this file do not reach."""

    def pytest_ignore_collect(self, collection_path, config):
        """Ignore the plugins that are not installed by default, unless their tests are asked for."""
        return True if "not peers" in config.option.markexpr and is_optional(collection_path) else None

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items):
        """Mark tests by the fixtures that they use, and those of plugins that are not installed by default."""
        for item in items:
            if PEER_FIXTURES.intersection(getattr(item, "fixturenames", ())) or is_optional(item.path):
                item.add_marker("peers")

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item):
        """In CI, let a test fail that is skipped."""
        report = yield
        if report.skipped and "peers" in item.keywords and os.environ.get("CI"):
            report.outcome, report.longrepr = "failed", f"CI must not skip it: {reason_of(report)}"
        return report


def is_optional(path):
    """True in the folder of a plugin that the core does not install."""
    parts = path.relative_to(ROOT).parts
    needs = [need.partition("==")[0] for need in SETTINGS["project"]["dependencies"]]
    return len(parts) > 1 and parts[0] == "plugins" and parts[1] not in needs


def reason_of(report):
    """Why a test was skipped."""
    text = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
    return str(text).removeprefix("Skipped: ")


def pytest_configure(config):
    """Let the rules hold in all folders, and tests interrupt programs also where a shell started them in background."""
    config.pluginmanager.register(Peers())
    # Tests start hundreds of processes: modules and kernels are compiled once, also where a test moves the user's cache.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder()))
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def fake_plugin(tmp_path_factory):
    """A directory for PYTHONPATH with an installed plugin, as far as ``importlib.metadata`` can tell."""
    folder = tmp_path_factory.mktemp("site")
    shutil.copy(Path(__file__).parent / "cli" / "fake_plugin" / "driftform_fake.py", folder)
    write_metadata(folder, "driftform-fake", "fake = driftform_fake")
    return folder


@pytest.fixture
def fakes(fake_plugin, monkeypatch):
    """The plugin in this process, and in those that it starts."""
    from driftform.plugins.registry import registry

    monkeypatch.syspath_prepend(str(fake_plugin))
    registry.cache_clear()
    yield
    registry.cache_clear()
    sys.modules.pop("driftform_fake", None)


@pytest.fixture
def count_of():
    """How many of something to take: what the environment says (``AGENTS=20 pytest ...``), or what the page says."""
    return lambda name, usual: int(os.environ.get(name, usual))


@pytest.fixture(scope="session")
def uv():
    """The installer that plugins are installed by."""
    # ``uv run`` says where it is; otherwise it is looked for on the path.
    found = os.environ.get("UV") or shutil.which("uv")
    if found is None:
        pytest.skip("uv is not installed")
    return found


@pytest.fixture(scope="session")
def outside(uv):
    """Run a program as if there were no virtual environment of the tests; gives what it printed on stdout."""

    def done(*words, cwd):
        environment = {k: v for k, v in os.environ.items() if k not in ("VIRTUAL_ENV", "PYTHONPATH")}
        ended = subprocess.run(
            [*map(str, words)], cwd=cwd, env=environment, capture_output=True, text=True, timeout=600, check=False
        )
        assert ended.returncode == 0, ended.stdout + ended.stderr
        return ended.stdout

    return done


@pytest.fixture(scope="session")
def dist(uv, outside, tmp_path_factory):
    """A directory with the wheels and sdists of all distributions; a wheel is built from its sdist."""
    folder = shared_folder(tmp_path_factory, "dist")
    with FileLock(folder.with_suffix(".lock")):
        if not folder.exists():
            outside(uv, "build", "--all-packages", "--out-dir", folder.with_suffix(".part"), cwd=ROOT)
            folder.with_suffix(".part").rename(folder)
    return folder


@pytest.fixture(scope="session")
def new_environment(uv, outside, tmp_path_factory):
    """Make an environment of some distributions and what they need, and nothing else; gives where its programs are."""
    dated = SETTINGS["tool"]["uv"]["exclude-newer"]

    def made(*distributions):
        folder = tmp_path_factory.mktemp("elsewhere")
        outside(uv, "venv", "--python", sys.executable, "env", cwd=folder)
        chosen = ("--python", folder / "env", "--exclude-newer", dated)
        outside(uv, "pip", "install", *chosen, *distributions, cwd=folder)
        return folder / "env" / ("Scripts" if os.name == "nt" else "bin")

    return made


class Program(subprocess.Popen[Any]):
    """A program that ends with its context if that fails, where ``Popen`` would wait for it."""

    def __exit__(self, kind, *rest):
        if kind is not None:
            self.kill()
        super().__exit__(kind, *rest)


@pytest.fixture(scope="session")
def start(fake_plugin):
    """Start the installed program."""

    def started(*args, cwd):
        return Program(
            [PROGRAM, *map(str, args)],
            cwd=cwd,
            env=os.environ | {"PYTHONPATH": str(fake_plugin)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    return started


@pytest.fixture(scope="session")
def run(start):
    """Run the installed program to its end."""

    def finished(*args, cwd):
        with start(*args, cwd=cwd) as process:
            out, err = process.communicate(timeout=600)
        return subprocess.CompletedProcess(args, process.returncode, out, err)

    return finished


@pytest.fixture(scope="session")
def dask(fake_plugin):
    """Start ``dask scheduler`` or ``dask worker``; what a worker dies of is for the scheduler's client to find out."""

    def started(*args, cwd):
        environment = {"PYTHONPATH": str(fake_plugin), "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}
        return Program(
            [PROGRAM.with_stem("dask"), *map(str, args)],
            cwd=cwd,
            env=os.environ | environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    return started


@pytest.fixture(scope="session")
def dask_scheduler(dask, tmp_path_factory):
    """Run a Dask scheduler by its own command line, for as long as it is needed; gives its address, and its process."""

    @contextmanager
    def running():
        folder = tmp_path_factory.mktemp("scheduler")
        file = folder / "scheduler.json"
        options = ("--host", "127.0.0.1", "--port", 0, "--no-dashboard", "--scheduler-file", file)
        with dask("scheduler", *options, cwd=folder) as process:
            try:
                # It is there before anything is in it.
                while not file.exists() or not file.stat().st_size:
                    assert process.poll() is None, "the scheduler ended"
                    time.sleep(0.05)
                yield json.loads(file.read_text())["address"], process
            finally:
                process.kill()

    return running


@pytest.fixture(scope="session")
def dask_cluster(dask, dask_scheduler, tmp_path_factory):
    """The address of a cluster with two workers, one of them with threads to spare."""
    folder = tmp_path_factory.mktemp("workers")
    options = ("--no-dashboard", "--local-directory", folder)
    with (
        dask_scheduler() as (address, _),
        dask("worker", address, "--nthreads", 1, *options, cwd=folder) as one,
        dask("worker", address, "--nthreads", 3, *options, cwd=folder) as other,
    ):
        try:
            yield address
        finally:
            one.terminate()
            other.terminate()


@pytest.fixture(scope="session")
def finished_run(run, tmp_path_factory):
    """A small real run, and what the program said; not to be changed. All workers have the same."""
    cwd = shared_folder(tmp_path_factory, "finished")
    cwd.mkdir(exist_ok=True)
    targets = ("--target", "TP1", "--target", "TP7")
    words = ("evolve", "paper", *targets, "--simulator", "native", "--evaluations", 20, "--seed", 1, "--workers", 1)
    said = cwd / "said.json"
    with FileLock(cwd / ".lock"):
        if not said.exists():
            result = run(*words, "--out", "run", "--json", cwd=cwd)
            assert result.returncode == 0, result.stderr
            said.write_text(json.dumps([result.stdout, result.stderr]))
    return cwd / "run", subprocess.CompletedProcess(words, 0, *json.loads(said.read_text()))


@pytest.fixture
def run_copy(finished_run, tmp_path):
    """A copy of the small real run, to do harm to."""
    return Path(shutil.copytree(finished_run[0], tmp_path / "run"))


@pytest.fixture
def agent_document(finished_run):
    """A sound agent.json."""
    text = (finished_run[0] / "best" / "TP1" / "agent.json").read_text()
    document = json.loads(text)
    return document


@pytest.fixture(scope="session")
def rows():
    """All that a run found, to the last digit; not how long it took."""

    def read(directory):
        connection = sqlite3.connect(directory / "run.db")
        try:
            columns = (
                "id, generation, population, parents, grammar, symbols, seed, failure, ended, duration, trajectory"
            )
            evaluations = connection.execute(f"SELECT {columns} FROM evaluation ORDER BY id").fetchall()
            scores = connection.execute("SELECT * FROM score ORDER BY target, evaluation").fetchall()
        finally:
            connection.close()
        return [*evaluations, *scores]

    return read
