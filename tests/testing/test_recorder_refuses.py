"""The contract of recorders is of use only if it refuses recorders that are wrong: each of these has one fault."""

import itertools
from pathlib import Path

import pytest

from driftform.interfaces import ExportJob, Recorder
from driftform.testing import RecorderContract
from driftform.types import End, Trajectory, WrittenFile
from driftform.util.files import write_text
from driftform.util.options import Table

TICKS = itertools.count()


class Plain(Recorder[Table]):
    """Times and heights, one line each."""

    name = "plain"
    suffix = ".txt"

    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        """Write the file."""
        rows = zip(trajectory.t, trajectory.position, trajectory.quaternion, strict=True)
        write_text(path, "".join(f"{t} {p.tolist()} {q.tolist()}\n" for t, p, q in rows))
        return (WrittenFile(self.name, str(path)),)


class LeavesAnotherFile(Plain):
    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        path.parent.mkdir(exist_ok=True, parents=True)
        path.with_suffix(".tmp").write_text("left over")
        return super().write(job, trajectory, path)


class ReportsNothing(Plain):
    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        super().write(job, trajectory, path)
        return ()


class WritesTheClock(Plain):
    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        write_text(path, f"{next(TICKS)} {trajectory.quaternion.tolist()}")
        return (WrittenFile(self.name, str(path)),)


class NeedsTwoSamples(Plain):
    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        trajectory.t[1]
        return super().write(job, trajectory, path)


class RefusesFailures(Plain):
    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        if trajectory.end.failed:
            raise ValueError(trajectory.end)
        return super().write(job, trajectory, path)


class NeedsAPipe(Plain):
    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        job.scenario.pipe.segments[0]
        return super().write(job, trajectory, path)


class ForgetsTheFlight(Plain):
    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        write_text(path, job.name)
        return (WrittenFile(self.name, str(path)),)


class LeavesHalfAFile(Plain):
    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        path.parent.mkdir(exist_ok=True, parents=True)
        part = path.with_suffix(".part")
        part.write_text(str(trajectory.quaternion.tolist()))
        part.replace(path)
        return (WrittenFile(self.name, str(path)),)


def contract(cls: type[Plain]) -> RecorderContract:
    class Contract(RecorderContract):
        def plugin(self) -> Plain:
            return cls(Table())

    return Contract()


FILES, SAME, SINGLE, OPEN, OTHER, BLOCKED = CHECKS = (
    "test_only_the_requested_files_are_written",
    "test_the_same_job_gives_the_same_content",
    "test_a_flight_of_one_sample_is_recorded_too",
    "test_a_flight_in_open_water_is_recorded_too",
    "test_another_flight_gives_other_content",
    "test_a_failed_write_leaves_nothing_behind",
)


@pytest.mark.parametrize("check", CHECKS)
def test_a_sound_recorder_passes(check: str, tmp_path: Path) -> None:
    getattr(contract(Plain), check)(tmp_path)


@pytest.mark.parametrize(
    ("cls", "check"),
    [
        (LeavesAnotherFile, FILES),
        (ReportsNothing, FILES),
        (WritesTheClock, SAME),
        (NeedsTwoSamples, SINGLE),
        (NeedsAPipe, OPEN),
        (ForgetsTheFlight, OTHER),
        (LeavesHalfAFile, BLOCKED),
    ],
)
def test_a_faulty_recorder_is_refused(cls: type[Plain], check: str, tmp_path: Path) -> None:
    with pytest.raises((AssertionError, IndexError)):
        getattr(contract(cls), check)(tmp_path)


def test_a_recorder_that_refuses_failed_flights_is_refused(tmp_path: Path) -> None:
    contract(Plain).test_a_flight_that_failed_is_recorded_too(End.NON_FINITE, tmp_path)
    with pytest.raises(ValueError, match="non-finite"):
        contract(RefusesFailures).test_a_flight_that_failed_is_recorded_too(End.NON_FINITE, tmp_path)
