"""The example tracks of docs/calibration.md: what the program prints, and its pictures. ``UPDATE_DOCS=1`` writes both."""

import os
import re
import shlex
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from driftform.cli.app import app

pytestmark = pytest.mark.long

PAGE = "calibration.md"
PICTURES = {"e4": "calibration-ten-cate-e4.svg"}


NUMBER = re.compile(r"\d+\.?\d*")


def are_alike(text: str, other: str) -> bool:
    """True if the words are the same and the numbers differ by at most 10 %: a fit to bounces magnifies rounding."""
    numbers = [[float(n) for n in NUMBER.findall(t)] for t in (text, other)]
    words = [" ".join(NUMBER.sub("", t).split()) for t in (text, other)]
    return words[0] == words[1] and numbers[0] == pytest.approx(numbers[1], rel=0.1)


def test_pages_whose_words_or_numbers_differ_are_not_alike() -> None:
    assert are_alike("drag 1.00 to  2", "drag 1.05 to 2")
    assert not are_alike("drag 1.00 to 2", "drag 1.00 or 2")
    assert not are_alike("drag 1.00 to 2", "drag 1.20 to 2")


def test_examples_print_what_the_page_shows(
    docs: Path,
    blocks: list[Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    up_to_date: Callable[[Path, str], None],
) -> None:
    shutil.copytree(docs / "tracks", tmp_path / "tracks")
    monkeypatch.chdir(tmp_path)
    text = (docs / PAGE).read_text(encoding="utf-8")
    shown = [block for block in blocks if block.page == PAGE and "calibration" in block.words]
    assert len(shown) == len(PICTURES)
    for block in shown:
        command = block.text.splitlines()[0]
        result = CliRunner().invoke(app, shlex.split(command)[2:])
        assert result.exit_code == 0, result.stderr
        text = text.replace(block.text, f"{command}\n{result.stdout}")
    kept = (docs / PAGE).read_text(encoding="utf-8")
    if os.environ.get("UPDATE_DOCS") == "1" or not are_alike(text, kept):
        up_to_date(docs / PAGE, text)
    for folder, name in PICTURES.items():
        drawn = Path(folder, "tracks.svg").read_text(encoding="utf-8")
        if os.environ.get("UPDATE_DOCS") == "1":
            (docs / "images" / name).write_text(drawn, encoding="utf-8")
        # Other machines may differ in the last digits of a path.
        kept = (docs / "images" / name).read_text(encoding="utf-8")
        assert kept.split("<path")[0] == drawn.split("<path")[0]
        assert kept.count('class="seen"') == drawn.count('class="seen"') > 10


def test_the_python_example_runs(
    docs: Path, blocks: list[Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(docs / "tracks", tmp_path / "tracks")
    monkeypatch.chdir(tmp_path)
    [block] = [block for block in blocks if block.page == PAGE and block.file.endswith(".py")]
    exec(compile(block.text, str(block), "exec"), {})
    factor, residual = map(float, capsys.readouterr().out.split())
    assert factor == pytest.approx(1.14, abs=0.02)
    assert 0 < residual < 0.002
