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
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import pytest
from chromium import browser
from filelock import FileLock
from program import call, ideal_water, install, refused, write_metadata
from shared import shared_folder

from driftform.util.files import cache_folder

__all__ = ["browser", "call", "ideal_water", "install", "refused"]

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
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DOCS = ROOT / "docs"
PROGRAM = Path(sysconfig.get_path("scripts")) / ("driftform.exe" if os.name == "nt" else "driftform")


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Return a worker for each core, or 0 (one process) for single files, slow tests, and tests that write pages."""
    folders = any(Path(name).is_dir() for name in config.args)
    if not folders or "not slow" not in config.option.markexpr or os.environ.get("UPDATE_DOCS") == "1":
        return 0
    return min(MAX_WORKERS, os.cpu_count() or 1)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """Compile the kernels before the workers start, so that no test waits for them."""
    command = (sys.executable, "-c", KERNELS)
    processes = [
        subprocess.Popen([*command, simulator, str(ROOT / "tests" / "helpers")]) for simulator in ("native", "exudyn")
    ]
    assert [process.wait() for process in processes] == [0, 0]


class Peers:
    """What holds for tests of ``peers``, also for those of plugins, which hooks of this file do not reach."""

    def pytest_ignore_collect(self, collection_path: Path, config: pytest.Config) -> bool | None:
        """Ignore the plugins that are not installed by default, unless their tests are asked for."""
        return True if "not peers" in config.option.markexpr and is_optional(collection_path) else None

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Mark tests by the fixtures that they use, and those of plugins that are not installed by default."""
        for item in items:
            if PEER_FIXTURES.intersection(getattr(item, "fixturenames", ())) or is_optional(item.path):
                item.add_marker("peers")

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item) -> Iterator[None]:
        """In CI, let a test fail that is skipped."""
        report = yield
        if report.skipped and "peers" in item.keywords and os.environ.get("CI"):
            report.outcome, report.longrepr = "failed", f"CI must not skip it: {reason_of(report)}"
        return report

    def pytest_report_teststatus(self, report: pytest.TestReport) -> tuple[str, str, str] | None:
        """Count the tests apart that lack their peer, so that they are one line of the summary."""
        lacks = report.skipped and "peers" in report.keywords
        return ("without their peer", "s", "SKIPPED") if lacks else None

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Say in one line what is not installed."""
        if lacking := terminalreporter.stats.get("without their peer"):
            reasons = sorted({reason_of(report) for report in lacking})
            terminalreporter.write_line(f"{len(lacking)} tests skipped: {'; '.join(reasons)}")


def is_optional(path: Path) -> bool:
    """True in the folder of a plugin that the core does not install."""
    parts = path.relative_to(ROOT).parts
    needs = [need.partition("==")[0] for need in PROJECT["dependencies"]]
    return len(parts) > 1 and parts[0] == "plugins" and parts[1] not in needs


def reason_of(report: pytest.TestReport) -> str:
    """Why a test was skipped."""
    text = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
    return str(text).removeprefix("Skipped: ")


def pytest_configure(config: pytest.Config) -> None:
    """Let the rules hold in all folders, and tests interrupt programs also where a shell started them in background."""
    config.pluginmanager.register(Peers())
    # Tests start hundreds of processes: modules and kernels are compiled once, also where a test moves the user's cache.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder()))
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def fake_plugin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A directory for PYTHONPATH with an installed plugin, as far as ``importlib.metadata`` can tell."""
    folder = tmp_path_factory.mktemp("site")
    shutil.copy(Path(__file__).parent / "cli" / "fake_plugin" / "driftform_fake.py", folder)
    write_metadata(folder, "driftform-fake", "fake = driftform_fake")
    return folder


@pytest.fixture
def fakes(fake_plugin: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The plugin in this process, and in those that it starts."""
    from driftform.plugins.registry import registry

    monkeypatch.syspath_prepend(str(fake_plugin))
    registry.cache_clear()
    yield
    registry.cache_clear()
    sys.modules.pop("driftform_fake", None)


@pytest.fixture
def count_of() -> Callable[[str, int], int]:
    """How many of something to take: what the environment says (``AGENTS=20 pytest ...``), or what the page says."""
    return lambda name, usual: int(os.environ.get(name, usual))


@pytest.fixture(scope="session")
def uv() -> str:
    """The installer that plugins are installed by."""
    # ``uv run`` says where it is; otherwise it is looked for on the path.
    found = os.environ.get("UV") or shutil.which("uv")
    if found is None:
        pytest.skip("uv is not installed")
    return found


@pytest.fixture(scope="session")
def outside(uv: str) -> Callable[..., str]:
    """Run a program as if there were no virtual environment of the tests; gives what it printed on stdout."""

    def done(*words: object, cwd: Path) -> str:
        environment = {k: v for k, v in os.environ.items() if k not in ("VIRTUAL_ENV", "PYTHONPATH")}
        ended = subprocess.run(
            [*map(str, words)], cwd=cwd, env=environment, capture_output=True, text=True, timeout=600, check=False
        )
        assert ended.returncode == 0, ended.stdout + ended.stderr
        return ended.stdout

    return done


@pytest.fixture(scope="session")
def dist(uv: str, outside: Callable[..., str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A directory with the wheels and sdists of all distributions; a wheel is built from its sdist."""
    folder = shared_folder(tmp_path_factory, "dist")
    with FileLock(folder.with_suffix(".lock")):
        if not folder.exists():
            outside(uv, "build", "--all-packages", "--out-dir", folder.with_suffix(".part"), cwd=ROOT)
            folder.with_suffix(".part").rename(folder)
    return folder


@pytest.fixture(scope="session")
def new_environment(
    uv: str, outside: Callable[..., str], tmp_path_factory: pytest.TempPathFactory
) -> Callable[..., Path]:
    """Make an environment of some distributions and what they need, and nothing else; gives where its programs are."""
    project = tomllib.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))
    dated = project["tool"]["uv"]["exclude-newer"]

    def made(*distributions: object) -> Path:
        folder = tmp_path_factory.mktemp("elsewhere")
        outside(uv, "venv", "--python", sys.executable, "env", cwd=folder)
        chosen = ("--python", folder / "env", "--exclude-newer", dated)
        outside(uv, "pip", "install", *chosen, *distributions, cwd=folder)
        return folder / "env" / ("Scripts" if os.name == "nt" else "bin")

    return made


class Program(subprocess.Popen[Any]):
    """A program that ends with its context if that fails, where ``Popen`` would wait for it."""

    def __exit__(self, kind: type[BaseException] | None, *rest: Any) -> None:
        if kind is not None:
            self.kill()
        super().__exit__(kind, *rest)


@pytest.fixture(scope="session")
def start(fake_plugin: Path) -> Callable[..., subprocess.Popen[str]]:
    """Start the installed program."""

    def started(*args: object, cwd: Path) -> subprocess.Popen[str]:
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
def run(start: Callable[..., subprocess.Popen[str]]) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run the installed program to its end."""

    def finished(*args: object, cwd: Path) -> subprocess.CompletedProcess[str]:
        with start(*args, cwd=cwd) as process:
            out, err = process.communicate(timeout=600)
        return subprocess.CompletedProcess(args, process.returncode, out, err)

    return finished


@pytest.fixture(scope="session")
def dask(fake_plugin: Path) -> Callable[..., subprocess.Popen[bytes]]:
    """Start ``dask scheduler`` or ``dask worker``; what a worker dies of is for the scheduler's client to find out."""

    def started(*args: object, cwd: Path) -> subprocess.Popen[bytes]:
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
def dask_scheduler(
    dask: Callable[..., subprocess.Popen[bytes]], tmp_path_factory: pytest.TempPathFactory
) -> Callable[[], AbstractContextManager[tuple[str, subprocess.Popen[bytes]]]]:
    """Run a Dask scheduler by its own command line, for as long as it is needed; gives its address, and its process."""

    @contextmanager
    def running() -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
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
def dask_cluster(
    dask: Callable[..., subprocess.Popen[bytes]],
    dask_scheduler: Callable[[], AbstractContextManager[tuple[str, object]]],
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[str]:
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
def finished_run(
    run: Callable[..., subprocess.CompletedProcess[str]], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, subprocess.CompletedProcess[str]]:
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
def run_copy(finished_run: tuple[Path, object], tmp_path: Path) -> Path:
    """A copy of the small real run, to do harm to."""
    return Path(shutil.copytree(finished_run[0], tmp_path / "run"))


@pytest.fixture
def agent_document(finished_run: tuple[Path, object]) -> dict[str, Any]:
    """A sound agent.json."""
    text = (finished_run[0] / "best" / "TP1" / "agent.json").read_text()
    document: dict[str, Any] = json.loads(text)
    return document


@pytest.fixture(scope="session")
def rows() -> Callable[[Path], list[tuple[Any, ...]]]:
    """All that a run found, to the last digit; not how long it took."""

    def read(directory: Path) -> list[tuple[Any, ...]]:
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


def _around(title: str) -> tuple[Path, str, str, str]:
    """The page that has a place for a table, what comes before it, what is there, and the rest."""
    begin, end = f"<!-- {title} -->\n\n", f"\n\n<!-- end of {title} -->"
    for page in sorted(DOCS.glob("*.md")):
        head, found, rest = page.read_text(encoding="utf-8").partition(begin)
        table, closed, tail = rest.partition(end)
        if found:
            assert closed, f"{page.name} does not say where '{title}' ends"
            return page, head + begin, table, end + tail
    raise AssertionError(f"no page of docs has a place for '{title}'")


@pytest.fixture
def publish() -> Callable[[str, Sequence[str]], None]:
    """Show lines of Markdown; with UPDATE_DOCS=1 put them between the markers of their title, too."""

    def published(title: str, lines: Sequence[str]) -> None:
        print("\n" + "\n".join(lines))
        if os.environ.get("UPDATE_DOCS") == "1":
            page, head, _, tail = _around(title)
            page.write_text(head + "\n".join(lines) + tail, encoding="utf-8")

    return published


@pytest.fixture
def published(publish: Callable[[str, Sequence[str]], None]) -> Callable[[str, Sequence[str]], None]:
    """Check that lines are what a page has between the markers of their title; with UPDATE_DOCS=1 put them there."""

    def check(title: str, lines: Sequence[str]) -> None:
        publish(title, lines)
        page, _, table, _ = _around(title)
        assert table == "\n".join(lines), f"{page.name} is out of date: run this test with UPDATE_DOCS=1"

    return check
