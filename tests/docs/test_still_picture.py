"""The picture of a flight in README.md, made by the command that is told there.

``UPDATE_DOCS=1 pytest -m slow tests/docs/test_still_picture.py`` makes it anew.
"""

import os
import re
import shlex
import shutil
import struct
from pathlib import Path

import pytest
from typer.testing import CliRunner

from driftform.cli.app import app

README = Path(__file__).parents[2] / "README.md"


def commands():
    """The words of the command that evolves the run, and of the one that makes the picture."""
    text = README.read_text(encoding="utf-8")
    found = []
    for pattern in (r"driftform (evolve --s[^\n]+)", r"`driftform (simulate [^`]+ --still [^`]+)`"):
        match = re.search(pattern, text)
        assert match, pattern
        found.append(shlex.split(match[1]))
    return found[0], found[1]


@pytest.mark.slow
def test_the_commands_of_the_readme_make_its_picture(docs, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for command in commands():
        result = CliRunner().invoke(app, command)
        assert result.exit_code == 0, result.output
    made, path = (tmp_path / "flight.png").read_bytes(), docs / "images" / "flight.png"
    if os.environ.get("UPDATE_DOCS") == "1":
        path.write_bytes(made)
        shutil.copy(tmp_path / "r1" / "figures" / "overview.svg", docs / "images")
    kept = path.read_bytes()
    assert struct.unpack(">II", kept[16:24]) == struct.unpack(">II", made[16:24]) == (1280, 800)
    # Processors that round otherwise evolve other agents.
    assert len(kept) < 300_000 and len(made) < 300_000


def test_the_readme_shows_it():
    assert "(docs/images/flight.png)" in README.read_text(encoding="utf-8")
    assert commands()[1][1].startswith(f"{commands()[0][-1]}:")
