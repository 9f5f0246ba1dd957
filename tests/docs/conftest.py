"""Reading the pages under ``docs/``: their fenced blocks and their generated parts."""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"

_FENCE = re.compile(r"^```(\w+)?([^\n`]*)\n(.*?)^```\s*$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A fenced block: its page, its language, the words after it, its text, and its line on the page."""

    page: str
    language: str
    words: tuple[str, ...]
    text: str
    line: int

    @property
    def file(self):
        """The file that the block shows, ``""`` where it shows none."""
        return next((word.removeprefix("file=") for word in self.words if word.startswith("file=")), "")

    def __str__(self):
        return f"{self.page}:{self.line}"


def read_blocks(page):
    """The fenced blocks of a page."""
    text = page.read_text(encoding="utf-8")
    return [
        Block(page.name, m[1] or "", tuple(m[2].split()), m[3], text.count("\n", 0, m.start()) + 1)
        for m in _FENCE.finditer(text)
    ]


def without_blocks(text):
    """The prose of a page: fenced blocks become empty lines."""
    return _FENCE.sub(lambda m: "\n" * m[0].count("\n"), text)


@pytest.fixture(scope="session")
def docs():
    return DOCS


@pytest.fixture(scope="session")
def pages():
    """Text of every page by its path within ``docs``."""
    return {str(path.relative_to(DOCS)): path.read_text(encoding="utf-8") for path in sorted(DOCS.rglob("*.md"))}


@pytest.fixture(scope="session")
def prose(pages):
    return {name: without_blocks(text) for name, text in pages.items()}


@pytest.fixture(scope="session")
def blocks():
    """All fenced blocks of all pages."""
    return [block for path in sorted(DOCS.glob("*.md")) for block in read_blocks(path)]


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The site, built from a copy: a build in the tree would leave files there."""
    folder = tmp_path_factory.mktemp("site")
    for name in ("docs", "src"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "mkdocs.yml", folder)
    done = subprocess.run(
        [sys.executable, "-m", "zensical", "build", "--strict"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "site"


@pytest.fixture
def same_picture():
    """Compare a picture with the one that a page shows; with UPDATE_DOCS=1 replace that."""

    def check(path, drawn):
        if os.environ.get("UPDATE_DOCS") == "1":
            path.write_text(drawn, encoding="utf-8")
        kept = path.read_text(encoding="utf-8")
        number = re.compile(r"-?\d+(?:\.\d+)?")
        assert number.sub("#", kept) == number.sub("#", drawn)
        # Other machines round other digits.
        values = [np.array([float(v) for v in number.findall(text)]) for text in (kept, drawn)]
        assert np.abs(values[0] - values[1]).max() < 0.02

    return check


@pytest.fixture
def run_example(blocks, capsys):
    """Run the example of a page that is a file; returns what it prints, and its names."""

    def run(page, file):
        [block] = [block for block in blocks if (block.page, block.file) == (page, file)]
        names = {"__name__": "__docs__"}
        capsys.readouterr()
        exec(compile("\n" * block.line + block.text, page, "exec"), names)
        return capsys.readouterr().out, names

    return run
