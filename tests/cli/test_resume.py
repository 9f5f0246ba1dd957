"""A run that is given a larger budget ends as one that had it from the start."""

import json
import re
import shutil
import sqlite3
import tomllib
from pathlib import Path

import pytest

from driftform.runs.store import Store

pytestmark = pytest.mark.long


STUDY = ("paper", "--target", "TP1", "--target", "TP8", "--seed", 5, "--simulator", "fake", "--workers", 1)


def budgets(directory):
    """What the database and resolved.toml say of the budget."""
    resolved = tomllib.loads((directory / "resolved.toml").read_text())
    with Store.open(directory / "run.db", read_only=True) as store:
        return store.read_study()["run"]["evaluations"], resolved["run"]["evaluations"]


def set_budget(directory, evaluations):
    """As if the run had been stopped on its way to a larger budget."""
    with Store.open(directory / "run.db") as store:
        study = store.read_study()
        store.write_facts("study", {**study, "run": {**study["run"], "evaluations": evaluations}})


@pytest.fixture(scope="module")
def sixty(run, tmp_path_factory):
    """A finished run; not to be changed."""
    cwd = tmp_path_factory.mktemp("sixty")
    result = run("evolve", *STUDY, "--evaluations", 60, "--out", "run", cwd=cwd)
    assert result.returncode == 0, result.stderr
    return cwd / "run"


@pytest.fixture(scope="module")
def more(run, sixty, tmp_path_factory):
    """The same with twice the budget, and what was told of the second half; not to be changed."""
    cwd = tmp_path_factory.mktemp("more")
    shutil.copytree(sixty, cwd / "run")
    result = run("resume", "run", "--evaluations", 120, "--workers", 1, "--json", cwd=cwd)
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["evaluations"] == 120
    return cwd / "run", result.stderr


@pytest.fixture
def copy(sixty, tmp_path):
    return Path(shutil.copytree(sixty, tmp_path / "run"))


def test_resumed_with_twice_the_budget_all_files_are_those_of_a_run_that_had_it(run, rows, more, tmp_path):
    result = run("evolve", *STUDY, "--evaluations", 120, "--out", "whole", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    whole, resumed = tmp_path / "whole", more[0]
    assert rows(resumed) == rows(whole)
    assert len(rows(whole)) == 120 * 3
    for name in ("resolved.toml", "study.toml", "best/TP8/agent.json", "figures/overview.svg"):
        assert (resumed / name).read_bytes() == (whole / name).read_bytes()


def test_the_larger_budget_stays_with_the_run(sixty, more, tmp_path):
    assert budgets(sixty) == (60, 60)
    assert budgets(more[0]) == (120, 120)


def test_what_was_stored_before_is_not_told_again(more):
    counts = [int(count) for count in re.findall(r": (\d+)/120 evaluations", more[1])]
    assert min(counts) >= 60 and counts[-1] == 120


def test_a_run_that_stopped_early_may_be_given_less(run, rows, copy, more):
    set_budget(copy, 500)
    result = run("resume", "run", "--evaluations", 80, "--workers", 1, cwd=copy.parent)
    assert result.returncode == 0, result.stderr
    assert budgets(copy) == (80, 80)
    evaluations = [row for row in rows(more[0]) if len(row) > 3 and row[0] < 80]
    assert [row for row in rows(copy) if len(row) > 3] == evaluations


def test_a_crash_between_database_and_resolved_study_is_made_good(call, copy, fakes, monkeypatch):
    from driftform.runs import run as owner

    def crashing(*_):
        raise OSError("the power went")

    with monkeypatch.context() as patch:
        patch.setattr(owner, "write_inputs", crashing)
        assert call("resume", "run", "--evaluations", 61, "--workers", 1).exit_code == 1
    assert budgets(copy) == (61, 60)
    result = call("resume", "run", "--workers", 1, "--json")
    assert json.loads(result.stdout)["evaluations"] == 61
    assert budgets(copy) == (61, 61)


def test_less_than_is_there_is_refused_and_the_run_is_left_as_it_was(copy, fakes, refused):
    line = refused("resume", "run", "--evaluations", 59)
    assert line == "error: --evaluations 59 is less than run holds already; give at least 60"


def test_what_counts_is_the_last_evaluation_and_not_how_many_there_are(copy, fakes, refused):
    connection = sqlite3.connect(copy / "run.db")
    connection.execute("DELETE FROM score WHERE evaluation BETWEEN 5 AND 57")
    connection.execute("DELETE FROM evaluation WHERE id BETWEEN 5 AND 57")
    connection.commit()
    connection.close()
    assert refused("resume", "run", "--evaluations", 20).endswith("give at least 60")


def test_a_run_that_has_ended_is_resumed_without_reading_an_evaluation_again(call, fakes, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ended = call("evolve", *STUDY, "--evaluations", 20, "--out", "run", "--json")
    assert ended.exit_code == 0

    def refuse(*_):
        raise AssertionError("a run that has ended reads its evaluations, however many there are")

    for name in ("read_records", "read_summaries", "read_trajectories"):
        monkeypatch.setattr(Store, name, refuse)
    result = call("resume", "run", "--json")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["targets"] == json.loads(ended.stdout)["targets"]
