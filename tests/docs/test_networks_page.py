"""The examples of docs/networks.md: what the commands print, the run and its fleet, and the figure."""

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from shared import shared_folder
from typer.testing import CliRunner

from driftform.cli.app import app

pytestmark = [pytest.mark.long, pytest.mark.peers]

PAGE = "networks.md"

QUICKLY = {"evolve": ["--evaluations", "40", "--workers", "1"]}


@pytest.fixture(autouse=True)
def _in_an_empty_folder(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(shared_folder(tmp_path_factory, "networks")))


def carry_out(line: str, *more: str) -> str:
    result = CliRunner().invoke(app, [*shlex.split(line)[2:], *more])
    assert result.exit_code == 0, f"{line}: {result.stderr}"
    return result.stdout


def test_the_commands_print_what_the_page_shows(
    docs: Path, blocks: list[Any], up_to_date: Callable[[Path, str], None]
) -> None:
    page = docs / PAGE
    text = page.read_text(encoding="utf-8")
    shown = [block for block in blocks if block.page == PAGE and "network" in block.words]
    for block in shown:
        line = block.text.splitlines()[0]
        text = text.replace(block.text, f"{line}\n{carry_out(line)}")
    assert len(shown) == 4
    up_to_date(page, text)
    up_to_date(docs / "images" / "network-route.svg", Path("town.svg").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_a_run_becomes_a_fleet_and_a_fleet_becomes_parts(blocks: list[Any]) -> None:
    plain = [block for block in blocks if block.page == PAGE and block.language == "console" and not block.words]
    lines = [line for block in plain for line in block.text.splitlines()]
    assert [shlex.split(line)[2] for line in lines] == ["evolve", "network", "export"]
    for line in lines[:2]:
        carry_out(line, *QUICKLY.get(shlex.split(line)[2], []))
    members = sorted(Path("members").iterdir())
    assert members
    carry_out(lines[2].replace("members/AGENT.json", str(members[0])))
    assert list(Path("parts").glob("*.3mf"))


def test_the_example_in_python_runs(blocks: list[Any], capsys: pytest.CaptureFixture[str]) -> None:
    [block] = [block for block in blocks if block.page == PAGE and block.file == "town.py"]
    exec(compile(block.text, PAGE, "exec"), {"__name__": "__docs__"})
    assert capsys.readouterr().out == "water 0.297, sphere 0.297, five spheres 0.372\n"
