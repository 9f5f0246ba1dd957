"""Solved tees on disk: those of a new shape are solved once, and nothing is charged for it."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from driftform.runs.run import StoredRun
from driftform.search.advance import search_run
from driftform.search.local import InProcess
from driftform.study import load_study
from driftform.util import preparation
from driftform.util.files import CACHE_VARIABLE
from driftform.water.parts import tee_store as store
from driftform.water.parts.tee_store import load_tee
from driftform.water.parts.tee_wall import Junction

SHAPE = Junction(0.4, math.radians(75), 0.08)


@pytest.fixture
def solved(tmp_path, monkeypatch):
    """The shapes that are solved, each by the potentials of another one, in a cache that begins empty."""
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    known, shapes = load_tee(store.JUNCTIONS[0]), []

    def compute(junction):
        shapes.append(junction)
        return known

    monkeypatch.setattr(store, "_compute", compute)
    load_tee.cache_clear()
    return shapes


def test_a_tee_of_a_new_shape_is_solved_once_and_then_read(solved):
    first = load_tee(SHAPE)
    load_tee.cache_clear()
    again = load_tee(SHAPE)
    assert solved == [SHAPE]
    assert np.array_equal(again.branch, first.branch, equal_nan=True)


@pytest.mark.parametrize("damage", [b"", b"text", b"PK\x03\x04" + bytes(200)])
def test_a_damaged_file_in_the_cache_is_made_again_with_one_line(solved, capsys, damage):
    first = load_tee(SHAPE)
    [file] = store.cache_folder().glob("*.npz")
    sound = file.read_bytes()
    for data in (damage, sound[: len(sound) // 2], sound[:600] + damage + sound[600 + len(damage) + 1 :]):
        file.write_bytes(data)
        load_tee.cache_clear()
        assert np.array_equal(load_tee(SHAPE).branch, first.branch, equal_nan=True)
        said = capsys.readouterr().err
        assert said.startswith(f"{file} is damaged (") and said.count("\n") == 1
    assert solved == [SHAPE] * 4


def test_the_clock_of_an_evaluation_stops_while_a_tee_is_solved(solved, monkeypatch):
    reports = []
    monkeypatch.setattr(preparation, "_report", lambda begins: reports.append((begins, len(solved))))
    load_tee(SHAPE)
    load_tee(store.JUNCTIONS[1])
    assert reports == [(True, 0), (False, 1)]


@pytest.mark.usefixtures("fakes")
def test_a_search_solves_the_tees_of_its_pipe_before_its_first_flight(solved, tmp_path):
    study = load_study(
        "t-junction",
        ["pipe.parts.3.fillet=0.012", "robustness.conditions=0"],
        use={"simulator": "fake"},
        run={"seed": 0, "evaluations": 1},
    )
    flown = []

    def evaluate(jobs):
        flown.append(list(solved))
        return InProcess(study.make_pipeline()).evaluate(jobs)

    with StoredRun.create(tmp_path / "run", study) as run:
        search_run(run, SimpleNamespace(evaluate=evaluate, begin=None))
    assert len(solved) == 1 and flown[0] == solved
