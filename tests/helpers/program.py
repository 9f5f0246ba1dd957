"""Fixtures of the tests of driftform and of its plugins: the program, called in this process, and other programs."""

import json
import shutil
import sys

import pytest


@pytest.fixture
def call(tmp_path, monkeypatch):
    """Call the program in this process, in an empty directory."""
    from typer.testing import CliRunner

    from driftform.cli.app import app

    monkeypatch.chdir(tmp_path)
    return lambda *args: CliRunner().invoke(app, [str(arg) for arg in args], prog_name="driftform")


@pytest.fixture
def done(call):
    """Call the program, which does what it is asked; return what it prints, and of ``--json`` the document."""

    def printed(*args):
        result = call(*args)
        assert result.exit_code == 0, result.stderr
        return json.loads(result.stdout) if "--json" in args else result.stdout

    return printed


@pytest.fixture
def refused(call, tmp_path):
    """Call the program with bad input; it says so in one line and leaves nothing behind. Return the line."""

    def line_of(*args):
        before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*") if path.is_file()}
        folders = {path for path in tmp_path.rglob("*") if path.is_dir()}
        result = call(*args)
        assert isinstance(result.exception, SystemExit), result.exception
        assert result.exit_code == 2, result.stderr
        assert result.stdout == ""
        lines = result.stderr.splitlines()
        assert len(lines) == 1, result.stderr
        assert lines[0].startswith("error: ")
        after = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*") if path.is_file()}
        locks = {path for path in after if path.name == ".lock"}
        assert {path: when for path, when in after.items() if path not in locks} == {
            path: when for path, when in before.items() if path not in locks
        }
        assert {path for path in tmp_path.rglob("*") if path.is_dir()} == folders
        return lines[0]

    return line_of


@pytest.fixture
def ideal_water(monkeypatch):
    """Make the paper's scenario the default in this process: its numbers have closed forms, and it takes less time."""
    monkeypatch.setattr("driftform.study.study.DEFAULT", "paper")


def write_metadata(site, name, point, version="1.0"):
    """Let ``importlib.metadata`` find a distribution with an entry point of driftform in a folder."""
    info = site / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    (info / "entry_points.txt").write_text(f"[driftform]\n{point}\n")


@pytest.fixture
def install(tmp_path_factory, monkeypatch):
    """Install modules as distributions ``<module>-plugin 1.0``, beside the directory that the program works in."""
    from driftform.cli.added import load_added

    site = tmp_path_factory.mktemp("site")
    monkeypatch.syspath_prepend(str(site))
    modules = []

    def installed(**sources):
        for module, source in sources.items():
            (site / f"{module}.py").write_text(source)
            write_metadata(site, f"{module}-plugin", f"{module} = {module}")
            modules.append(module)
        load_added.cache_clear()

    yield installed
    for module in modules:
        sys.modules.pop(module, None)
    load_added.cache_clear()


@pytest.fixture(scope="session")
def requires_program():
    """Path of a program; without it the test is skipped."""

    def find(name):
        path = shutil.which(name)
        if path is None:
            pytest.skip(f"{name} is not installed")
        return path

    return find
