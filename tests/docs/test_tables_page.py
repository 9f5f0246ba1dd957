"""The examples of docs/tables.md, on a run as the page makes it."""

import shlex
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from driftform.cli.app import app

PAGE = "tables.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory, blocks):
    """Where the page's commands were carried out, but quickly."""
    folder = tmp_path_factory.mktemp("results")
    quickly = {"evolve": ["--simulator", "native", "--evaluations", "60", "--workers", "1"]}
    [block] = [b for b in blocks if b.page == PAGE and b.language == "console"]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for line in block.text.splitlines():
            words = shlex.split(line)[2:]
            result = CliRunner().invoke(app, [*words, *quickly.get(words[0], [])])
            assert result.exit_code == 0, result.stderr
    return folder


@pytest.fixture
def shown(folder, run_example, monkeypatch):
    """Run an example; return what it prints, and its names."""
    monkeypatch.chdir(folder)
    return lambda name: run_example(PAGE, name)


def test_every_example_is_tried_here(blocks):
    here = Path(sys.modules[__name__].__file__ or "").read_text(encoding="utf-8")
    assert [b.file for b in blocks if b.page == PAGE and b.file and f'shown("{b.file}")' not in here] == []


@pytest.mark.peers
def test_the_best_error_so_far_never_rises(shown):
    out, names = shown("best_so_far.py")
    best, errors = names["best"], names["errors"]
    assert list(best.columns) == ["fitness_TP1", "fitness_TP7"]
    assert (best.diff().iloc[1:] <= 0).all().all()
    for column, evaluation in errors.idxmin().items():
        assert errors[column][evaluation] == best[column].iloc[-1]
    assert "fitness_TP7" in out


@pytest.mark.peers
def test_generations_are_those_of_the_paper(shown):
    out, names = shown("generations.py")
    sizes = names["own"].group_by("target", "generation").len()
    # Sixty evaluations of two populations of ten.
    assert sizes.height == 6 and set(sizes["len"]) == {10}
    assert len(names["long"]) == 120
    assert "mass and fitness" in out


@pytest.mark.peers
def test_descent_ends_at_a_random_genome(shown):
    _, names = shown("descent.py")
    line, runs = names["line"], names["runs"]
    assert line == sorted(line, reverse=True)
    assert runs.loc[line[0], "fitness_TP7"] == runs["fitness_TP7"].max()
    assert runs.loc[line[-1], "generation"] == 0


@pytest.mark.peers
def test_flights_are_joined_with_their_bodies(shown):
    _, names = shown("flights.py")
    found = names["found"]
    assert found["evaluation"].to_list() == list(range(60))
    assert (found["lowest"] <= 0).all()
    # What is released on the axis and sinks is at some time below it.
    assert (found.filter(found["net_buoyancy"] < -0.1)["lowest"] < -0.1).all()


@pytest.mark.peers
def test_units_are_as_told(shown):
    out, _ = shown("units.py")
    assert out == "net buoyancy, N\nthe same from the file itself: N\n"
