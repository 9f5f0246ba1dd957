"""``plugins``, ``scenarios``, ``--help`` and ``--version``; and readers that stop reading."""

import json
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
from pydantic import Field

import driftform
from driftform.options import Table, describe, option

Call = Callable[..., Any]

BUILT_IN = {
    ("grammar", "lsystem"),
    ("builder", "frusta"),
    ("hydrodynamics", "striptheory"),
    ("simulator", "exudyn"),
    ("fitness", "closest-approach"),
    ("strategy", "paper"),
    ("strategy", "random"),
    ("exporter", "stl"),
    ("renderer", "exudyn"),
}


@pytest.mark.parametrize("args", [("plugins",), ("plugins", "list")])
def test_plugins_are_listed_by_seam_with_where_they_come_from(call: Call, args: tuple[str, ...]) -> None:
    rows = json.loads(call(*args, "--json").stdout)["plugins"]
    assert {(row["seam"], row["name"]) for row in rows} >= BUILT_IN
    assert all(row.keys() == {"seam", "name", "distribution", "version", "state"} for row in rows)
    lines = call(*args).stdout.splitlines()
    assert lines[0].split() == ["seam", "name", "distribution", "version", "state"]
    assert len(lines) == 1 + len(rows)


def test_json_may_stand_before_or_after_list(call: Call) -> None:
    for group in ("plugins", "scenarios"):
        assert json.loads(call(group, "list", "--json").stdout) == json.loads(call(group, "--json").stdout)


def test_a_plugin_of_someone_else_is_listed_and_shown(call: Call, fakes: None) -> None:
    rows = json.loads(call("plugins", "--json").stdout)["plugins"]
    assert {
        "seam": "simulator",
        "name": "fake",
        "distribution": "driftform-fake",
        "version": "1.0",
        "state": "ok",
    } in rows
    text = call("plugins", "show", "fake").stdout
    assert text.startswith("simulator fake, from driftform-fake 1.0")
    assert "share of the genomes that end their process" in text


def test_the_options_of_a_plugin_are_shown_with_default_and_unit(call: Call) -> None:
    [entry] = json.loads(call("plugins", "show", "frusta", "--json").stdout)["plugins"]
    options = {option["option"]: option for option in entry["options"]}
    assert options["hull_density"]["unit"] == "kg/m3"
    assert options["hull_density"]["default"] == 1050.0
    assert all(option["help"] for option in options.values())
    assert "hull_density" in call("plugins", "show", "frusta").stdout


def test_a_plugin_without_options_says_so(call: Call) -> None:
    assert "It has no options." in call("plugins", "show", "closest-approach").stdout


def test_types_are_written_as_people_write_them_and_a_default_that_is_missing_is_told() -> None:
    class Needy(Table):
        genome: str = option(..., "the genome to try")
        box: tuple[Annotated[float, Field(gt=0)], float] = option((1.0, 2.0), "width and height", "m")
        names: tuple[str, ...] = option((), "names of all")
        way: Literal["up", "down"] | None = option(None, "where to")

    assert [(row["option"], row["type"], row["default"]) for row in describe(Needy)] == [
        ("genome", "str", "required"),
        ("box", "[float, float]", (1.0, 2.0)),
        ("names", "list of str", ()),
        ("way", "'up' or 'down' or none", None),
    ]


def test_a_sound_study_is_told_by_what_it_holds(call: Call) -> None:
    lines = ['base = "pipe-inspection"', "[targets]", "leak = [1, 0, 0]", "[exporter.stl]", "segments = 32"]
    Path("mine.toml").write_text("\n".join(lines))
    told = json.loads(call("scenarios", "check", "mine.toml", "--json").stdout)
    assert told["targets"] == {"leak": [1, 0, 0]}
    assert (told["pipe"], told["flow"], told["evaluations"]) == (1, "uniform", 50)
    assert told["plugins"]["strategy"] == "paper"
    assert told["options"] == {"exporter": ["stl"], "recorder": [], "renderer": [], "checker": []}
    text = call("scenarios", "check", "mine.toml").stdout
    assert text.startswith("mine.toml is sound")
    assert "1: leak" in text
    assert sorted(path.name for path in Path().iterdir()) == ["mine.toml"]


def test_all_that_is_wrong_with_a_study_is_told_with_its_line(call: Call) -> None:
    lines = ['base = "pipe-inspection"', "[flow]", "sped = 1", "[fitness]", 'use = "closest"']
    Path("mine.toml").write_text("\n".join(lines))
    for more in ((), ("--json",)):
        result = call("scenarios", "check", "mine.toml", *more)
        assert (result.exit_code, result.stdout) == (2, "")
        assert result.stderr.splitlines() == [
            "error: mine.toml:3: unknown key 'sped' in [flow]; did you mean 'speed'?",
            "error: mine.toml:5: no fitness is named 'closest'; did you mean 'closest-approach'?",
        ]


def test_scenarios_are_listed_and_shown_as_toml_to_copy(call: Call) -> None:
    rows = json.loads(call("scenarios", "--json").stdout)["scenarios"]
    assert {row["name"]: row["targets"] for row in rows}["pipe-inspection"] == 10
    text = call("scenarios", "show", "pipe-inspection").stdout
    document = json.loads(call("scenarios", "show", "pipe-inspection", "--json").stdout)
    assert document == {"name": "pipe-inspection", "scenario": tomllib.loads(text)}
    assert "pipe-inspection" in call("scenarios").stdout


def test_a_scenario_that_was_copied_is_a_study(call: Call) -> None:
    Path("mine.toml").write_text(call("scenarios", "show", "pipe-inspection").stdout)
    assert call("sample", "--scenario", "mine.toml", "--count", 1, "--out", "out").exit_code == 0


def test_help_and_version(call: Call) -> None:
    assert call("--version").stdout == f"driftform {driftform.__version__}\n"
    for args in ((), ("evolve",), ("plugins", "show")):
        assert "Usage" in call(*args, "--help").stdout
    assert "Usage" in call().output


@pytest.mark.skipif(sys.platform == "win32", reason="closes a POSIX pipe")
@pytest.mark.parametrize("args", [("plugins",), ("scenarios", "show", "pipe-inspection"), ("--help",)])
def test_a_reader_that_stops_early_sees_no_traceback(
    start: Callable[..., subprocess.Popen[str]], tmp_path: Path, args: tuple[str, ...]
) -> None:
    with start(*args, cwd=tmp_path) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == ""
