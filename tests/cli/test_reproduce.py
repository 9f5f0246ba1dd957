"""``driftform reproduce``: the paper's experiment, with flights that cost nothing."""

import json
import signal
import sqlite3
import time
from pathlib import Path

import numpy as np
import pytest

from driftform.runs.store import Store

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def reproduced(start, tmp_path_factory):
    """Two repeats of each search."""
    out = tmp_path_factory.mktemp("reproduction") / "out"
    process = start(
        *("reproduce", "--repeats", "2", "--seed", "3", "--simulator", "fake", "--out", out, "--workers", "1"),
        "--json",
        cwd=out.parent,
    )
    printed, told = process.communicate(timeout=600)
    assert process.returncode == 0, told
    return out, json.loads(printed)


def errors_of(directory):
    """Populations, errors (flights, targets) and targets of a run, read past driftform."""
    with sqlite3.connect(directory / "run.db") as db:
        populations = [row[0] for row in db.execute("SELECT population FROM evaluation ORDER BY id")]
        rows = db.execute("SELECT target, evaluation, fitness FROM score").fetchall()
    names = list(dict.fromkeys(target for target, *_ in rows))
    errors = np.zeros((len(populations), len(names)))
    for target, evaluation, fitness in rows:
        errors[evaluation, names.index(target)] = 100 - fitness
    return populations, errors, names


def test_the_table_is_that_of_fifty_flights_for_each_target(reproduced):
    out, document = reproduced
    for target in ("TP1", "TP7"):
        own, blocks = [], []
        for seed in (3, 4):
            populations, errors, names = errors_of(out / "runs" / f"paper-{seed}")
            mine = [index for index, population in enumerate(populations) if population == target]
            assert len(mine) == 50
            own.append(errors[mine, names.index(target)].min())
            _, errors, names = errors_of(out / "runs" / f"random-{seed}")
            first = 50 * list(document["targets"]).index(target)
            blocks.append(errors[first : first + 50, names.index(target)].min())
        for name, expected in (("paper", own), ("random", blocks)):
            told = document["targets"][target][name]
            assert told["mean"] == pytest.approx(np.mean(expected))
            assert told["std"] == pytest.approx(np.std(expected))
            assert told["worst"] == pytest.approx(np.max(expected))


def test_agents_that_are_flown_again_in_the_same_water_do_exactly_the_same(reproduced):
    assert all(row["resimulated_std"] == 0 for row in reproduced[1]["targets"].values())


def test_tables_and_figures_are_where_they_are_said_to_be(reproduced):
    out, document = reproduced
    text = Path(document["results"]).read_text()
    assert text.count("| TP10 |") == 2
    assert "worst case below 5 %" in text
    assert {Path(path).name for path in document["figures"]} == {
        f"{name}.{kind}" for name in ("fitness", "shapes", "trajectories") for kind in ("svg", "png")
    }
    assert all(Path(path).stat().st_size > 1000 for path in document["figures"])
    assert (out / "figures" / "fitness.png").read_bytes().startswith(b"\x89PNG")


def test_the_same_seed_gives_the_same_tables_also_after_an_interruption(reproduced, start, tmp_path):
    out = tmp_path / "again"
    command = ("reproduce", "--repeats", "2", "--seed", "3", "--simulator", "fake", "--out", out, "--workers", "2")
    process = start(*command, cwd=tmp_path)
    database = out / "runs" / "paper-4" / "run.db"
    deadline = time.monotonic() + 600
    while not database.is_file() and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=600)
    assert process.returncode == 130
    assert f"driftform reproduce --out {out}" in told
    with Store.open(out / "runs" / "paper-3" / "run.db", read_only=True) as store:
        assert store.count() == 500
    process = start(*command, cwd=tmp_path)
    process.communicate(timeout=600)
    assert process.returncode == 0
    assert (out / "results.md").read_text() == (reproduced[0] / "results.md").read_text()


def test_other_settings_in_the_same_directory_are_refused(reproduced, start):
    process = start(
        *("reproduce", "--repeats", "2", "--seed", "3", "--simulator", "fake", "--out", reproduced[0]),
        *("--set", "flow.speed=0.5"),
        cwd=reproduced[0],
    )
    _, told = process.communicate(timeout=600)
    assert process.returncode == 2
    assert "paper-3: holds a run with other settings (flow); choose another --out" in told
