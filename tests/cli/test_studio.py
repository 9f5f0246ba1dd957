"""``driftform studio`` without its package: a line that says what to install, and nothing slower or larger."""

import tomllib
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace

import pytest

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def fail() -> None:
    raise ModuleNotFoundError("No module named 'starlette'")


@pytest.mark.parametrize("points", [[], [SimpleNamespace(load=fail)]], ids=["missing", "broken"])
def test_without_the_extra_one_line_says_what_to_install(call, monkeypatch, tmp_path, points):
    real = metadata.entry_points
    monkeypatch.setattr(
        metadata,
        "entry_points",
        lambda **keys: points if keys.get("group") == "driftform.studio" else real(**keys),
    )
    result = call("studio", "--no-browser")
    assert result.exit_code == 1 and result.stdout == ""
    assert result.stderr == (
        'error: the page is not installed; run: uv sync --extra studio, or pip install "driftform[studio]"\n'
    )
    assert list(tmp_path.iterdir()) == []


def test_the_command_serves_what_the_entry_point_names(call, monkeypatch):
    served = []

    def serve(folder, port, announce, browser):
        served.append((folder, port, browser))
        announce("http://127.0.0.1:1/token/")

    monkeypatch.setattr(metadata, "entry_points", lambda **keys: [SimpleNamespace(load=lambda: serve)])
    result = call("studio", "mine", "--port", "8123", "--no-browser")
    assert result.exit_code == 0, result.output
    assert served == [(Path("mine"), 8123, False)]
    assert result.stdout.splitlines()[0] == "driftform studio: http://127.0.0.1:1/token/"


def test_the_extra_is_all_that_brings_a_server():
    names = {need.partition("=")[0].partition(">")[0] for need in PROJECT["dependencies"]}
    assert not names & {"driftform-studio", "starlette", "uvicorn", "fastapi", "nicegui"}
    assert PROJECT["optional-dependencies"]["studio"] == [f"driftform-studio=={PROJECT['version']}"]
