"""The pages that are walked through: their commands run in order and print what the pages show."""

import os
import re
import shlex
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from driftform.cli.app import app
from driftform.runs.directory import lock_run
from driftform.study import load_study

pytestmark = pytest.mark.long

QUICKLY = ("--simulator", "native", "--evaluations", "20", "--workers", "1")


def lines_of(block: Any, text: str) -> list[str]:
    """The lines of an output that a block shows: all, or those with the word of ``grep=``."""
    word = next((w.removeprefix("grep=") for w in block.words if w.startswith("grep=")), "")
    return [line for line in text.splitlines() if word in line]


def without_numbers(text: str) -> str:
    # Which target is the worst depends on the numbers.
    text = re.sub(r"(at worst \S+) \(.*?\)", r"\1", text)
    # So do the targets where a shape gains little.
    text = re.sub(r"the shape matters little for [^\n]*\n", "", text)
    # So does the target for which the doubt about gusts matters most.
    text = re.sub(r"(what is not known of gusts[^\n]*at most) \(.*?\)", r"\1", text)
    # So do the side to which an agent tends, and its pockets.
    text = re.sub(r"\(it (floats|sinks)\)|trim pockets [^\n]*\n", "", text)
    return re.sub(r"[ \n]+", " ", re.sub(r"[+-]?\d+(\.\d+)?(e[+-]\d+)?", "#", text))


def carry_out(blocks: list[Any], folder: Path, quickly: bool) -> dict[str, list[str]]:
    """What each block of commands should show."""
    found: dict[str, list[str]] = {}
    for block in blocks:
        if block.file:
            (folder / block.file).write_text(block.text, encoding="utf-8")
        if not {"runs", "setup"} & set(block.words):
            continue
        lines = []
        for command in (line for line in block.text.splitlines() if line.startswith("$ ")):
            words = shlex.split(command)[2:]
            result = CliRunner().invoke(app, [*words, *(QUICKLY if quickly and words[0] == "evolve" else ())])
            assert result.exit_code == 0, f"{command}: {result.output}"
            lines += [command, *(lines_of(block, result.stdout) if "runs" in block.words else [])]
        found[block.text] = lines
    return found


@pytest.mark.parametrize("page", ["start.md", "tutorial-cli.md", "printing.md"])
def test_commands_print_what_the_page_shows(
    page: str,
    docs: Path,
    blocks: list[Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    up_to_date: Callable[[Path, str], None],
) -> None:
    monkeypatch.chdir(tmp_path)
    mine = [block for block in blocks if block.page == page]
    original = text = (docs / page).read_text(encoding="utf-8")
    # The agent that docs/printing.md prints needs its whole run.
    found = carry_out(mine, tmp_path, quickly=page != "printing.md" and os.environ.get("UPDATE_DOCS") != "1")
    assert len(found) >= 4
    for shown, lines in found.items():
        text = text.replace(shown, "\n".join(lines) + "\n")
    # Shorter runs and other processors have other numbers.
    if os.environ.get("UPDATE_DOCS") == "1" or without_numbers(text) != without_numbers(original):
        up_to_date(docs / page, text)


@pytest.fixture(scope="module")
def troubled(tmp_path_factory: pytest.TempPathFactory, blocks: list[Any]) -> Path:
    """A directory with the run and the study that docs/troubleshooting.md speaks of."""
    import driftform as df

    folder = tmp_path_factory.mktemp("trouble")
    study = load_study(targets=["TP1", "TP3"], use={"simulator": "native"}, run={"seed": 1, "evaluations": 2})
    df.evolve(study, folder / "r1", progress=False)
    for block in blocks:
        if block.page == "troubleshooting.md" and block.file:
            (folder / block.file).write_text(block.text, encoding="utf-8")
    return folder


@pytest.mark.peers
def test_messages_are_those_that_the_program_prints(
    docs: Path,
    blocks: list[Any],
    troubled: Path,
    monkeypatch: pytest.MonkeyPatch,
    up_to_date: Callable[[Path, str], None],
) -> None:
    monkeypatch.chdir(troubled)
    page = docs / "troubleshooting.md"
    text = page.read_text(encoding="utf-8")
    count = 0
    for block in (b for b in blocks if b.page == page.name and "errors" in b.words):
        lines: list[str] = []
        for command in (line for line in block.text.splitlines() if line.startswith("$ ")):
            with lock_run(Path("r1")) if "locked" in block.words else nullcontext():
                result = CliRunner().invoke(app, shlex.split(command)[2:])
            greps = any(word.startswith("grep=") for word in block.words)
            assert greps or result.exit_code in (1, 2), f"{command}: {result.output}"
            told = result.stdout if greps else result.stderr
            told_lines = [line for line in lines_of(block, told) if greps or line.startswith("error: ")]
            assert told_lines, f"{command}: {result.output}"
            lines += [command, *told_lines]
            count += 1
        text = text.replace(block.text, "\n".join(lines) + "\n")
    assert count >= 12
    up_to_date(page, text)
