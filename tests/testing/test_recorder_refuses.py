"""The contract of recorders is of use only if it refuses recorders that are wrong: each of these has one fault."""

import itertools
from collections.abc import Callable
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


Write = Callable[[Plain, ExportJob, Trajectory, Path], tuple[WrittenFile, ...]]


def leave_another_file(plain: Plain, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
    write_text(path.with_suffix(".tmp"), "left over")
    return plain.write(job, trajectory, path)


def report_nothing(plain: Plain, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
    plain.write(job, trajectory, path)
    return ()


def write_only(text: Callable[[ExportJob, Trajectory], str]) -> Write:
    def write(plain: Plain, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        write_text(path, text(job, trajectory))
        return (WrittenFile(plain.name, str(path)),)

    return write


def refuse_unless(accepts: Callable[[ExportJob, Trajectory], object]) -> Write:
    def write(plain: Plain, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        if not accepts(job, trajectory):
            raise ValueError(trajectory.end)
        return plain.write(job, trajectory, path)

    return write


def leave_half_a_file(plain: Plain, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
    part = path.with_suffix(".part")
    write_text(part, str(trajectory.quaternion.tolist()))
    part.replace(path)
    return (WrittenFile(plain.name, str(path)),)


def contract(write: Write = Plain.write) -> RecorderContract:
    class Mine(Plain):
        def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
            return write(Plain(Table()), job, trajectory, path)

    class Contract(RecorderContract):
        def plugin(self) -> Plain:
            return Mine(Table())

        def copy(self) -> Plain:
            return Mine(Table())

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
    getattr(contract(), check)(tmp_path)


@pytest.mark.parametrize(
    ("write", "check"),
    [
        (leave_another_file, FILES),
        (report_nothing, FILES),
        (write_only(lambda job, flight: f"{next(TICKS)} {flight.quaternion.tolist()}"), SAME),
        (refuse_unless(lambda job, flight: len(flight.t) > 1), SINGLE),
        (refuse_unless(lambda job, flight: job.scenario.pipe.segments), OPEN),
        (write_only(lambda job, flight: job.name), OTHER),
        (leave_half_a_file, BLOCKED),
    ],
)
def test_a_faulty_recorder_is_refused(write: Write, check: str, tmp_path: Path) -> None:
    with pytest.raises((AssertionError, ValueError)):
        getattr(contract(write), check)(tmp_path)


def test_a_recorder_that_refuses_failed_flights_is_refused(tmp_path: Path) -> None:
    contract().test_a_flight_that_failed_is_recorded_too(End.NON_FINITE, tmp_path)
    with pytest.raises(ValueError, match="non-finite"):
        contract(refuse_unless(lambda job, flight: not flight.end.failed)).test_a_flight_that_failed_is_recorded_too(
            End.NON_FINITE, tmp_path
        )
