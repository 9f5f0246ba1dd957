"""The contract of recorders is of use only if it refuses recorders that are wrong: each of these has one fault."""

import itertools

import pytest

from driftform.interfaces import Recorder
from driftform.testing import RecorderContract
from driftform.types import End, WrittenFile
from driftform.util.files import write_text
from driftform.util.options import Table

TICKS = itertools.count()


class Plain(Recorder[Table]):
    """Times, places and attitudes, one line each: sound."""

    name, suffix = "plain", ".txt"

    def describe(self, job, flight):
        rows = zip(flight.t, flight.position, flight.quaternion, strict=True)
        return "".join(f"{t} {p.tolist()} {q.tolist()}\n" for t, p, q in rows)

    def write(self, job, flight, path):
        write_text(path, self.describe(job, flight))
        return (WrittenFile(self.name, str(path)),)


class LeavingAnotherFile(Plain):
    def write(self, job, flight, path):
        write_text(path.with_suffix(".tmp"), "left over")
        return super().write(job, flight, path)


class ReportingNothing(Plain):
    def write(self, job, flight, path):
        super().write(job, flight, path)
        return ()


class LeavingHalfAFile(Plain):
    def write(self, job, flight, path):
        part = path.with_suffix(".part")
        write_text(part, self.describe(job, flight))
        part.replace(path)
        return (WrittenFile(self.name, str(path)),)


def describing(text):
    return type("Describing", (Plain,), {"describe": lambda self, job, flight: text(job, flight)})


def refusing(refuses):
    def describe(self, job, flight):
        if refuses(job, flight):
            raise ValueError(flight.end)
        return Plain.describe(self, job, flight)

    return type("Refusing", (Plain,), {"describe": describe})


def contract(recorder):
    make = {name: lambda self: recorder(Table()) for name in ("plugin", "copy")}
    return type("Contract", (RecorderContract,), make)()


@pytest.mark.parametrize(
    ("recorder", "check"),
    [
        (LeavingAnotherFile, "test_only_the_requested_files_are_written"),
        (ReportingNothing, "test_only_the_requested_files_are_written"),
        (describing(lambda job, flight: f"{next(TICKS)} {flight.t}"), "test_the_same_job_gives_the_same_content"),
        (refusing(lambda job, flight: len(flight.t) == 1), "test_a_flight_of_one_sample_is_recorded_too"),
        (refusing(lambda job, flight: not job.scenario.pipe.segments), "test_a_flight_in_open_water_is_recorded_too"),
        (describing(lambda job, flight: job.name), "test_another_flight_gives_other_content"),
        (LeavingHalfAFile, "test_a_failed_write_leaves_nothing_behind"),
    ],
)
def test_a_faulty_recorder_is_refused(recorder, check, tmp_path):
    for folder in ("sound", "faulty"):
        (tmp_path / folder).mkdir()
    getattr(contract(Plain), check)(tmp_path / "sound")
    with pytest.raises((AssertionError, ValueError)):
        getattr(contract(recorder), check)(tmp_path / "faulty")


def test_a_recorder_that_refuses_failed_flights_is_refused(tmp_path):
    contract(Plain).test_a_flight_that_failed_is_recorded_too(End.NON_FINITE, tmp_path)
    refuses = contract(refusing(lambda job, flight: flight.end.failed))
    with pytest.raises(ValueError, match="non-finite"):
        refuses.test_a_flight_that_failed_is_recorded_too(End.NON_FINITE, tmp_path)
