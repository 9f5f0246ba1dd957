"""``driftform compare``: searches repeated over seeds, with flights that cost nothing."""

import csv
import json
import signal
import sqlite3
import time
from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.long

WORDS = ("compare", "paper", "--strategy", "random", "--strategy", "paper", "--seeds", "3", "--simulator", "fake")
TARGETS = ("--set", "targets={near=[3.0,0.0,0.5],far=[8.0,0.0,-0.2]}", "--evaluations", "40")


@pytest.fixture(scope="module")
def compared(start, tmp_path_factory):
    out = tmp_path_factory.mktemp("comparison") / "out"
    process = start(*WORDS, *TARGETS, "--out", out, "--workers", "1", "--json", cwd=out.parent)
    printed, told = process.communicate(timeout=600)
    assert process.returncode == 0, told
    return out, json.loads(printed)


def read_best(run):
    """The best fitness of a run for each target, read past driftform."""
    with sqlite3.connect(run / "run.db") as db:
        return dict(db.execute("SELECT target, max(fitness) FROM score GROUP BY target"))


def test_medians_are_those_of_the_runs_over_equally_many_flights(compared):
    out, document = compared
    medians = []
    for name in ("random", "paper"):
        found = document["searches"][name]
        assert found["runs"] == [str(out / "runs" / f"{name}-{seed}") for seed in (1, 2, 3)]
        best = [read_best(Path(run)) for run in found["runs"]]
        for target in ("near", "far"):
            assert found["fitness"][target]["median"] == np.median([row[target] for row in best])
        medians.append(np.median([np.mean(list(row.values())) for row in best]))
        assert found["fitness"]["all targets"]["median"] == pytest.approx(medians[-1])
    row = document["searches"]["paper"]["fitness"]["all targets"]
    assert row["difference"] == pytest.approx(medians[1] - medians[0])
    assert row["low"] <= row["difference"] <= row["high"] and 0 < row["p"] <= 1
    with Path(document["table"]).open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 3 * 2
    assert {float(row["fitness_percent"]) for row in rows if row["search"] == "paper" and row["seed"] == "2"} == set(
        read_best(out / "runs" / "paper-2").values()
    )
    assert all(Path(path).stat().st_size > 1000 for path in document["figures"])


def test_an_interruption_loses_nothing_and_what_is_complete_is_not_flown_again(compared, start, tmp_path):
    command = (*WORDS, *TARGETS, "--set", "simulator.pause=0.01", "--out", tmp_path / "out", "--workers", "2")
    process = start(*command, cwd=tmp_path)
    deadline = time.monotonic() + 600
    while not (tmp_path / "out" / "runs" / "random-2" / "run.db").is_file() and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=600)
    assert process.returncode == 130
    assert f"this continues: the same driftform compare --out {tmp_path / 'out'}" in told
    first = tmp_path / "out" / "runs" / "random-1" / "run.db"
    before = first.stat().st_mtime_ns
    process = start(*command, cwd=tmp_path)
    process.communicate(timeout=600)
    assert process.returncode == 0
    assert first.stat().st_mtime_ns == before
    assert (tmp_path / "out" / "comparison.csv").read_bytes() == (compared[0] / "comparison.csv").read_bytes()


def test_promises_are_compared_where_flights_are_disturbed(start, tmp_path):
    words = ("compare", "paper", "pipe-inspection", "--strategy", "random", "--simulator", "fake", "--seeds", "2")
    robust = ("--robust", "2", "--set", "robustness.checks=12", "--evaluations", "10", "--workers", "2")
    process = start(*words, *robust, *TARGETS[:2], "--json", "--out", "out", cwd=tmp_path)
    printed, told = process.communicate(timeout=600)
    assert process.returncode == 0, told
    for name, found in json.loads(printed)["searches"].items():
        agents = [json.loads((tmp_path / run / "best" / "far" / "agent.json").read_text()) for run in found["runs"]]
        misses = [1000 * agent["result"]["robust"]["weighed"]["p90"] for agent in agents]
        assert found["miss"]["far"]["median"] == pytest.approx(np.median(misses)), name


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("paper",), "nothing to compare: name two or more"),
        (("paper", "--strategy", "random", "--strategy", "random"), "two searches are called 'random'"),
        (("paper", "--strategy", "random", "--strategy", "papre"), "did you mean 'paper'?"),
    ],
)
def test_what_cannot_be_compared_is_refused_before_anything_is_written(words, said, refused):
    assert said in refused("compare", *words)
