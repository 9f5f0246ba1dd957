"""The commands of the pages: they run in order, and print what the pages show."""

import os
import re
import shlex
import shutil
from contextlib import nullcontext
from pathlib import Path

import pytest
from shared import shared_folder
from typer.testing import CliRunner

import driftform as df
from driftform.cli.app import app
from driftform.runs.directory import lock_run
from driftform.study import load_study

QUICKLY = ("--simulator", "native", "--evaluations", "20", "--workers", "1")
NUMBER = re.compile(r"\d+\.?\d*")


def lines_of(block, text):
    """The lines of an output that a block shows: all, or those with the word of ``grep=``; of errors those lines alone."""
    word = next((w.removeprefix("grep=") for w in block.words if w.startswith("grep=")), "")
    begin = "error: " if "errors" in block.words and not word else ""
    return [line for line in text.splitlines() if word in line and line.startswith(begin)]


def without_numbers(text):
    # Which target is the worst depends on the numbers.
    text = re.sub(r"(at worst \S+) \(.*?\)", r"\1", text)
    # So do the targets where a shape gains little, or the search found less than the baseline.
    text = re.sub(r"the (shape matters little|baseline is better) for [^\n]*\n", "", text)
    # So does the target for which the doubt about gusts matters most.
    text = re.sub(r"(what is not known of gusts[^\n]*at most) \(.*?\)", r"\1", text)
    # So do the side to which an agent tends, and its pockets.
    text = re.sub(r"\(it (floats|sinks)\)|trim pockets [^\n]*\n", "", text)
    return re.sub(r"[ \n]+", " ", re.sub(r"[+-]?\d+(\.\d+)?(e[+-]\d+)?", "#", text))


def have_the_same_words(text, other):
    """Shorter runs and other processors have other numbers."""
    return without_numbers(text) == without_numbers(other)


def have_similar_numbers(text, other):
    """True if the words are the same and the numbers differ by at most 10 %: a fit to bounces magnifies rounding."""
    numbers = [[float(n) for n in NUMBER.findall(t)] for t in (text, other)]
    words = [" ".join(NUMBER.sub("", t).split()) for t in (text, other)]
    return words[0] == words[1] and numbers[0] == pytest.approx(numbers[1], rel=0.1)


def are_equal(text, other):
    return text == other


def call(command, *more):
    """Call the program as a line of a page does."""
    return CliRunner().invoke(app, [*shlex.split(command)[2:], *more])


def carry_out(blocks, quickly):
    """Write the files of some blocks and carry out their commands; return what each block of commands should show."""
    found = {}
    for block in blocks:
        if block.file:
            Path(block.file).parent.mkdir(exist_ok=True)
            Path(block.file).write_text(block.text, encoding="utf-8")
        lines, fails, is_part = [], "errors" in block.words, any(word.startswith("grep=") for word in block.words)
        if not fails and not {"runs", "setup"} & set(block.words):
            continue
        for command in (line for line in block.text.splitlines() if line.startswith("$ ")):
            with lock_run(Path("r1")) if "locked" in block.words else nullcontext():
                result = call(command, *(QUICKLY if quickly and not fails and " evolve " in command else ()))
            assert (is_part and fails) or result.exit_code in ((1, 2) if fails else (0,)), f"{command}: {result.output}"
            told = lines_of(block, result.stderr if fails and not is_part else result.stdout)
            assert told or "runs" in block.words or "setup" in block.words, f"{command}: {result.output}"
            lines += [command, *(told if "setup" not in block.words else [])]
        found[block.text] = "\n".join(lines) + "\n"
    return found


PAGES = {
    "calibration.md": have_similar_numbers,
    "networks.md": are_equal,
    "printing.md": have_the_same_words,
    "start.md": have_the_same_words,
    "study-files.md": are_equal,
    "troubleshooting.md": are_equal,
    "tutorial-cli.md": have_the_same_words,
}
"""What the output of the commands has in common with that on the page."""


def mark(page):
    peers = [pytest.mark.peers] if page in ("networks.md", "troubleshooting.md") else []
    return pytest.param(page, marks=[] if page == "study-files.md" else [pytest.mark.long, *peers])


@pytest.fixture
def here(tmp_path, tmp_path_factory, monkeypatch):
    """Commands run in an empty folder; the networks of all tests share their files."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(shared_folder(tmp_path_factory, "networks")))


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("page", [mark(page) for page in PAGES])
def test_commands_print_what_the_page_shows(page, docs, blocks, up_to_date):
    is_update = os.environ.get("UPDATE_DOCS") == "1"
    if page == "calibration.md":
        shutil.copytree(docs / "tracks", "tracks")
    if page == "troubleshooting.md":
        study = load_study(targets=["TP1", "TP3"], use={"simulator": "native"}, run={"seed": 1, "evaluations": 2})
        df.evolve(study, "r1", progress=False)
    original = text = (docs / page).read_text(encoding="utf-8")
    # The agent that docs/printing.md prints needs its whole run.
    found = carry_out((b for b in blocks if b.page == page), quickly=page != "printing.md" and not is_update)
    assert found
    for shown, expected in found.items():
        text = text.replace(shown, expected)
    if is_update or not PAGES[page](text, original):
        up_to_date(docs / page, text)
    if page == "networks.md":
        up_to_date(docs / "images" / "network-route.svg", Path("town.svg").read_text(encoding="utf-8"))
    if page == "calibration.md":
        kept, drawn = docs / "images" / "calibration-ten-cate-e4.svg", Path("e4/tracks.svg").read_text(encoding="utf-8")
        if is_update:
            kept.write_text(drawn, encoding="utf-8")
        # Other machines may differ in the last digits of a path.
        assert kept.read_text(encoding="utf-8").split("<path")[0] == drawn.split("<path")[0]
        assert kept.read_text(encoding="utf-8").count('class="seen"') == drawn.count('class="seen"') > 10


@pytest.mark.slow
@pytest.mark.peers
@pytest.mark.usefixtures("here")
def test_a_run_becomes_a_fleet_and_a_fleet_becomes_parts(blocks):
    plain = [b for b in blocks if b.page == "networks.md" and b.language == "console" and not b.words]
    evolve, network, export = [line for block in plain for line in block.text.splitlines()]
    for line in (f"{evolve} --evaluations 40 --workers 1", network):
        assert call(line).exit_code == 0, line
    member, *_ = sorted(Path("members").iterdir())
    assert call(export.replace("members/AGENT.json", str(member))).exit_code == 0
    assert list(Path("parts").glob("*.3mf"))
