"""``scenarios``: those that are built in, and a study file that is checked."""

import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

Call = Callable[..., Any]


def test_a_sound_study_is_told_by_what_it_holds(call: Call) -> None:
    lines = ['base = "paper"', "[targets]", "leak = [1, 0, 0]", "[exporter.stl]", "segments = 32"]
    Path("mine.toml").write_text("\n".join(lines))
    told = json.loads(call("scenarios", "check", "mine.toml", "--json").stdout)
    assert told["targets"] == {"leak": [1, 0, 0]}
    assert (told["pipe"], told["flow"], told["evaluations"]) == (1, "uniform", 50)
    assert told["plugins"]["strategy"] == "paper"
    assert told["options"] == {
        "exporter": ["stl"],
        "recorder": [],
        "renderer": [],
        "checker": [],
        "inspector": [],
        "reporter": [],
    }
    text = call("scenarios", "check", "mine.toml").stdout
    assert text.startswith("mine.toml is sound")
    assert "1: leak" in text
    assert sorted(path.name for path in Path().iterdir()) == ["mine.toml"]


def test_all_that_is_wrong_with_a_study_is_told_with_its_line(call: Call) -> None:
    lines = ['base = "paper"', "[flow]", "sped = 1", "[fitness]", 'use = "closest"']
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
