"""Run directories that were left in the first moment, and those that go away while a run is under way."""

import os
import shutil

import pytest

from driftform.errors import WorkFailedError
from driftform.runs.run import StoredRun
from driftform.runs.store import Store
from driftform.search.advance import advance_run
from driftform.search.local import InProcess
from driftform.study import load_study

pytestmark = pytest.mark.usefixtures("fakes")

STUDY = ("evolve", "--strategy", "paper", "--simulator", "fake", "--target", "TP1", "--evaluations", 4)
RUN = (*STUDY, "--seed", 1, "--workers", 1, "--out")

MOMENTS = [
    (),
    (".run.db.1a.part", ".run.db.1a.part-journal"),
    ("run.db",),
    ("run.db", ".resolved.toml.1a2b3c4d.part"),
    ("run.db", "resolved.toml", ".study.toml.1a2b3c4d.part"),
    ("run.db", "resolved.toml", "study.toml", ".environment.json.1a2b3c4d.part"),
    ("run.db", "resolved.toml", "study.toml", "environment.json"),
]


@pytest.fixture
def whole(call, tmp_path):
    """A run that nothing has disturbed."""
    result = call(*RUN, "whole")
    assert result.exit_code == 0, result.stderr
    return tmp_path / "whole"


def leave(moment, whole):
    """A run directory as a process leaves it that is killed at a moment."""
    directory = whole.with_name("left")
    shutil.rmtree(directory, ignore_errors=True)
    directory.mkdir()
    (directory / ".lock").touch()
    for name in moment:
        if name == "run.db":
            Store.create(directory / name, StoredRun.open(whole).study.document).close()
        elif (whole / name).is_file():
            shutil.copy(whole / name, directory)
        else:
            (directory / name).write_text("the first ha")
    return directory


@pytest.mark.long
def test_what_a_run_leaves_that_is_killed_in_its_first_moment_is_taken_by_resume_or_by_evolve(call, whole, rows):
    expected = rows(whole)
    for moment in MOMENTS:
        directory = leave(moment, whole)
        result = call("resume", "left", "--workers", 1)
        if "run.db" in moment:
            assert result.exit_code == 0, (moment, result.stderr)
            assert rows(directory) == expected
            assert not list(directory.glob("*.part*")) and not list(directory.glob(".*.part*"))
            assert (directory / "study.toml").is_file() and (directory / "environment.json").is_file()
        else:
            # Nothing was written yet of what it was to do.
            assert result.exit_code == 2
            [line] = result.stderr.splitlines()
            assert line.endswith("start it again with the same 'driftform evolve' and --out left")
            result = call(*RUN, "left")
            assert result.exit_code == 0, (moment, result.stderr)
            assert rows(directory) == expected


def test_a_directory_of_something_else_is_taken_by_neither(call, tmp_path):
    for name in ("notes.txt", ".hidden.part", "run.db.part"):
        folder = tmp_path / "other"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        (folder / ".lock").touch()
        (folder / name).touch()
        assert call(*RUN, "other").exit_code == 2
        assert call("resume", "other").exit_code == 2
        assert (folder / name).exists()


class Disturbed(InProcess):
    """Does something to the run after its first task."""

    def __init__(self, run, disturb):
        super().__init__(run.study.make_pipeline())
        self._disturb = disturb

    def evaluate(self, jobs):
        for outcomes in super().evaluate(jobs):
            yield outcomes
            if self._disturb is not None:
                self._disturb()
                self._disturb = None


@pytest.mark.skipif(os.name == "nt", reason="Windows does not let a directory go that is in use")
@pytest.mark.parametrize("deed", ["moved", "deleted", "replaced"])
def test_a_run_whose_directory_goes_away_stops_and_says_so(tmp_path, rows, deed, monkeypatch):
    # So that the first are written before the directory goes away.
    monkeypatch.setattr("driftform.search.journal.UNWRITTEN_S", 0.0)
    study = load_study(
        None, use={"simulator": "fake", "strategy": "paper"}, targets=["TP1"], run={"seed": 1, "evaluations": 40}
    )
    path, other = tmp_path / "run", tmp_path / "other"

    def disturb():
        path.rename(other)
        if deed == "deleted":
            shutil.rmtree(other)
        elif deed == "replaced":
            shutil.copytree(other, path)

    with (
        pytest.raises(WorkFailedError, match=r"run\.db: was moved or deleted while the run was under way"),
        StoredRun.create(path, study) as run,
    ):
        advance_run(run, Disturbed(run, disturb))
    assert path.exists() == (deed == "replaced")
    if deed == "moved":
        with StoredRun.resume(other) as run:
            assert 0 < run.count()[0] < 40
            advance_run(run, InProcess(study.make_pipeline()))
        with StoredRun.create(path, study) as run:
            advance_run(run, InProcess(study.make_pipeline()))
        assert rows(other) == rows(path)
