"""The worked example of docs/printing.md: its commands run in their order and print what the page shows.

Numbers may differ in their last digits from one processor to the next, and so are not compared.
"""

import re
import shlex
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from driftform.cli.app import app

pytestmark = pytest.mark.long


def commands_of(block: Any) -> list[str]:
    return [line for line in block.text.splitlines() if line.startswith("$ ")]


def shown(block: Any, text: str) -> list[str]:
    """The lines of an output that a block shows: all, or those with the word of ``grep=``."""
    word = next((w.removeprefix("grep=") for w in block.words if w.startswith("grep=")), "")
    return [line for line in text.splitlines() if word in line]


def without_numbers(text: str) -> str:
    return re.sub(r" +", " ", re.sub(r"[+-]?\d+(\.\d+)?(e[+-]\d+)?", "#", text))


def test_the_worked_example_prints_what_the_page_shows(
    docs: Path,
    blocks: list[Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    up_to_date: Callable[[Path, str], None],
) -> None:
    page = docs / "printing.md"
    original = text = page.read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    ran = 0
    for block in blocks:
        if block.page != page.name or not {"setup", "runs"} & set(block.words):
            continue
        lines = []
        for command in commands_of(block):
            result = CliRunner().invoke(app, shlex.split(command)[2:])
            assert result.exit_code == 0, f"{command}: {result.output}"
            lines += [command, *(shown(block, result.stdout) if "runs" in block.words else [])]
            ran += 1
        text = text.replace(block.text, "\n".join(lines) + "\n")
    assert ran >= 4
    if without_numbers(text) != without_numbers(original):
        up_to_date(page, text)


@pytest.mark.peers
def test_the_pause_of_the_page_comes_once_before_the_first_layer_above_its_height(
    blocks: list[Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if shutil.which("prusa-slicer") is None:
        pytest.skip("prusa-slicer is not installed")
    monkeypatch.chdir(tmp_path)
    word = "-".join(["addF-tiltp-0-L-moveF"] * 3)
    made = CliRunner().invoke(app, ["export", word, "--kit", "--format", "3mf", "--out", "."])
    assert made.exit_code == 0, made.output
    next(tmp_path.glob("*.3mf")).rename("r1-TP5.3mf")
    [block] = [b for b in blocks if b.page == "printing.md" and "before-layer-gcode" in b.text]
    command = shlex.split(block.text.replace("\\\n", " "))
    subprocess.run(command, check=True, capture_output=True)
    printed = Path("r1-TP5.gcode").read_text(encoding="utf-8")
    commands = [line for line in printed.splitlines() if line.startswith((";Z:", "M601", ";TYPE:Skirt/Brim"))]
    assert commands.count("M601") == 1 and ";TYPE:Skirt/Brim" in commands
    place = commands.index("M601")
    below, above = (float(line[3:]) for line in commands[place - 2 : place])
    assert below <= 12.5 < above
