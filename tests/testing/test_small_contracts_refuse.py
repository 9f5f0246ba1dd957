"""The contracts of checkers and commands are of use only if they refuse what is wrong: each has one fault."""

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import typer

from driftform.cli.output import print_json
from driftform.errors import InputError
from driftform.interfaces import Checker, PrintJob, Table
from driftform.testing import CheckerContract, CommandsContract
from driftform.types import Finding, State

TICKS = itertools.count()
SOUND, SAME, MESH, PROGRAM = (
    "test_a_sound_file_does_not_fail",
    "test_the_same_file_gives_the_same_findings_and_is_not_changed",
    "test_a_file_that_is_not_a_mesh_does_not_pass",
    "test_a_missing_program_is_reported",
)


def find(state: State = State.PASS, detail: str = "text", count: int = 1) -> Callable[[PrintJob], list[Finding]]:
    """A check that finds the same in each file that begins as a text STL does, and refuses others."""

    def check(job: PrintJob) -> list[Finding]:
        for path in job.files:
            if not path.read_bytes().startswith(b"solid"):
                raise InputError(f"{path}: is not a text STL file")
        return [Finding("text", state, detail, path.stem) for path in job.files for _ in range(count)]

    return check


def litter(job: PrintJob) -> list[Finding]:
    job.files[0].with_suffix(".log").write_text("checked")
    return find()(job)


def count(job: PrintJob) -> list[Finding]:
    return find(detail=str(next(TICKS)))(job)


def check_by(check: Callable[[PrintJob], list[Finding]], program: str = "") -> Any:
    class Mine(Checker[Table]):
        name = "mine"

        def check(self, job: PrintJob) -> list[Finding]:
            return check(job)

    Mine.program = program

    class Contract(CheckerContract):
        def plugin(self) -> Mine:
            return Mine(Table())

        def copy(self) -> Mine:
            return Mine(Table())

    return Contract()


def call(contract: Any, test: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder.mkdir()
    more = {"monkeypatch": monkeypatch} if test == PROGRAM else {}
    getattr(contract, test)(tmp_path=folder, **more)


@pytest.mark.parametrize(
    ("check", "program", "test"),
    [
        (find(State.FAIL), "", SOUND),
        (find(detail="two\nlines"), "", SOUND),
        (find(detail=""), "", SOUND),
        (find(count=0), "", SOUND),
        (find(count=2), "", SOUND),
        (count, "", SAME),
        (litter, "", SAME),
        (lambda job: [Finding("text", State.PASS, "text")], "", MESH),
        (find(), "a-slicer", PROGRAM),
    ],
)
def test_a_faulty_checker_is_refused(check, program, test, tmp_path, monkeypatch):
    call(check_by(find()), test, tmp_path / "sound", monkeypatch)
    with pytest.raises((AssertionError, pytest.fail.Exception)):
        call(check_by(check, program), test, tmp_path / "faulty", monkeypatch)


def weigh(mass: float = typer.Option(1.0, help="Mass, kg."), json: bool = typer.Option(False, "--json", help="JSON.")):
    """Print a weight."""
    if mass <= 0:
        raise InputError("--mass: should be above 0")
    print_json({"weight": 1}) if json else print("1 N")


def without_help(json: bool = typer.Option(False, "--json", help="JSON.")):
    print("{}")


def without_help_of_an_option(mass: float = 1.0, json: bool = typer.Option(False, "--json", help="JSON.")):
    """Print a weight."""
    print("{}")


def lenient(
    mass: float = typer.Option(1.0, help="Mass, kg."), json: bool = typer.Option(False, "--json", help="JSON.")
):
    """Print a weight, also of less than nothing, and never as JSON."""
    print("1 N")


def commands_of(function: Callable[..., None], name: str) -> Any:
    class Contract(CommandsContract):
        works, fails = ((name,),), ((name, "--mass", "-1"),)

        def add(self, app: typer.Typer) -> None:
            app.command(name)(function)

    return Contract()


@pytest.mark.parametrize(
    ("function", "name", "test"),
    [
        (weigh, "Weigh", "test_each_command_and_option_has_a_name_and_a_help_text"),
        (without_help, "weigh", "test_each_command_and_option_has_a_name_and_a_help_text"),
        (without_help_of_an_option, "weigh", "test_each_command_and_option_has_a_name_and_a_help_text"),
        (lenient, "weigh", "test_a_call_that_works_exits_with_0"),
        (lenient, "weigh", "test_wrong_input_is_one_line_and_exits_with_2"),
    ],
)
def test_a_faulty_command_is_refused(function, name, test):
    getattr(commands_of(weigh, "weigh"), test)()
    with pytest.raises((AssertionError, ValueError)):
        getattr(commands_of(function, name), test)()
