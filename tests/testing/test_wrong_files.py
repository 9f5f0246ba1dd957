"""Recorders and checkers that are wrong in one way each, and the test of their contract that refuses them."""

import itertools

import pytest

from driftform.interfaces import Checker, Recorder
from driftform.testing import CheckerContract, RecorderContract
from driftform.types import End, Finding, State, WrittenFile
from driftform.util.files import write_text
from driftform.util.options import Table

TICKS = itertools.count()


class Lines(Recorder[Table]):
    """A line for each sample: sound."""

    name, suffix = "lines", ".txt"

    def tell(self, flight):
        return "\n".join(str(flight.position[k].tolist() + flight.quaternion[k].tolist()) for k in range(len(flight.t)))

    def write(self, job, trajectory, path):
        write_text(path, self.tell(trajectory))
        return (WrittenFile(self.name, str(path)),)


class Stamped(Lines):
    def tell(self, flight):
        return f"{next(TICKS)}\n{super().tell(flight)}"


class NamesAlone(Lines):
    def tell(self, flight):
        return "a flight"


class Sloping(Lines):
    def tell(self, flight):
        return f"{flight.t[1] - flight.t[0]}\n{super().tell(flight)}"


class SoundAlone(Lines):
    def tell(self, flight):
        assert not flight.end.failed
        return super().tell(flight)


class InPipesAlone(Lines):
    def write(self, job, trajectory, path):
        assert job.scenario.pipe.straight
        return super().write(job, trajectory, path)


class Littering(Lines):
    def write(self, job, trajectory, path):
        write_text(path.with_name("agent-notes.txt"), "notes")
        return super().write(job, trajectory, path)


class Torn(Lines):
    def write(self, job, trajectory, path):
        write_text(path.with_name(f"{path.name}.part"), self.tell(trajectory))
        path.with_name(f"{path.name}.part").replace(path)
        return (WrittenFile(self.name, str(path)),)


class Facets(Checker[Table]):
    """Whether a file has facets: sound."""

    name = "facets"

    def count(self, path):
        return path.read_bytes().count(b"endfacet")

    def check(self, job):
        for path in job.files:
            found = self.count(path)
            state = State.PASS if found else State.FAIL
            yield Finding("facets", state, f"{found} facets", path.stem)


class Lenient(Facets):
    def count(self, path):
        return 1


class Strict(Facets):
    def count(self, path):
        return 0


class Trembling(Facets):
    def count(self, path):
        return super().count(path) + next(TICKS)


class Scribbling(Facets):
    def count(self, path):
        path.with_suffix(".log").write_text("seen")
        return super().count(path)


class Mending(Facets):
    def count(self, path):
        path.write_bytes(path.read_bytes() + b"\n")
        return super().count(path)


class Doubling(Facets):
    def check(self, job):
        return [*super().check(job)] * 2


class Silent(Facets):
    def check(self, job):
        return ()


class WithoutProgram(Facets):
    program = "a-program-that-is-nowhere"


MISTAKES = {
    Stamped: ("test_the_same_job_gives_the_same_content", {}),
    NamesAlone: ("test_another_flight_gives_other_content", {}),
    Sloping: ("test_a_flight_of_one_sample_is_recorded_too", {}),
    SoundAlone: ("test_a_flight_that_failed_is_recorded_too", {"end": End.NON_FINITE}),
    InPipesAlone: ("test_a_flight_in_open_water_is_recorded_too", {}),
    Littering: ("test_only_the_requested_files_are_written", {}),
    Torn: ("test_a_failed_write_leaves_nothing_behind", {}),
    Lenient: ("test_a_file_that_is_not_a_mesh_does_not_pass", {}),
    Strict: ("test_a_sound_file_does_not_fail", {}),
    Doubling: ("test_a_sound_file_does_not_fail", {}),
    Silent: ("test_a_sound_file_does_not_fail", {}),
    Trembling: ("test_the_same_file_gives_the_same_findings_and_is_not_changed", {}),
    Scribbling: ("test_the_same_file_gives_the_same_findings_and_is_not_changed", {}),
    Mending: ("test_the_same_file_gives_the_same_findings_and_is_not_changed", {}),
    WithoutProgram: ("test_a_missing_program_is_reported", {"monkeypatch": None}),
}


@pytest.mark.parametrize("wrong", MISTAKES, ids=lambda wrong: wrong.__name__)
def test_a_mistake_with_files_is_refused_and_the_sound_plugin_is_not(wrong, tmp_path, monkeypatch):
    test, values = MISTAKES[wrong]
    contract = RecorderContract if issubclass(wrong, Lines) else CheckerContract
    given = {name: value or monkeypatch for name, value in values.items()}

    def run(plugin, folder):
        folder.mkdir()
        mine = type("Mine", (contract,), {"plugin": lambda self: plugin(Table())})()
        getattr(mine, test)(tmp_path=folder, **given)

    run(wrong.__base__, tmp_path / "sound")
    with pytest.raises((AssertionError, IndexError)):
        run(wrong, tmp_path / "wrong")
