"""The worked example of docs/printing.md: its commands run in their order and print what the page shows.

Numbers may differ in their last digits from one processor to the next, and so are not compared.
"""

import re
import shlex
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
