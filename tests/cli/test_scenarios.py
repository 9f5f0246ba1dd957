"""``scenarios``: those that are built in, and a study file that is checked."""

import json
import tomllib
from pathlib import Path


def test_a_sound_study_is_told_by_what_it_holds(call):
    lines = ['base = "paper"', "[targets]", "leak = [1, 0, 0]", "[exporter.stl]", "segments = 32"]
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


def test_all_that_is_wrong_with_a_study_is_told_with_its_line(call):
    lines = ['base = "paper"', "[flow]", "sped = 1", "[fitness]", 'use = "closest"']
    Path("mine.toml").write_text("\n".join(lines))
    for more in ((), ("--json",)):
        result = call("scenarios", "check", "mine.toml", *more)
        assert (result.exit_code, result.stdout) == (2, "")
        assert result.stderr.splitlines() == [
            "error: mine.toml:3: unknown key 'sped' in [flow]; did you mean 'speed'?",
            "error: mine.toml:5: no fitness is named 'closest'; did you mean 'closest-approach'?",
        ]


def test_scenarios_are_listed_and_shown_as_toml_to_copy(call):
    rows = json.loads(call("scenarios", "--json").stdout)["scenarios"]
    assert {row["name"]: row["targets"] for row in rows}["pipe-inspection"] == 10
    text = call("scenarios", "show", "pipe-inspection").stdout
    document = json.loads(call("scenarios", "show", "pipe-inspection", "--json").stdout)
    assert document == {"name": "pipe-inspection", "scenario": tomllib.loads(text)}
    assert "pipe-inspection" in call("scenarios").stdout


def test_a_picture_shows_what_is_wrong_with_a_study(call):
    lines = ['base = "pipe-inspection"', "[targets]", "high = [3.0, 0, 1.4]", "good = [4.0, 0, 0.2]"]
    Path("mine.toml").write_text("\n".join(lines))
    result = call("scenarios", "check", "mine.toml", "--picture", "mine.svg")
    assert result.exit_code == 2
    picture = Path("mine.svg").read_text()
    assert "lies outside the pipe" in picture.replace("\n", " ")
    assert picture.count('stroke="#b3261e"') == 1
    # A release outside, and then a pipe that cannot be laid.
    Path("mine.toml").write_text("\n".join([*lines, "[release]", "position = [0, 0, 3.0]"]))
    assert call("scenarios", "check", "mine.toml", "--picture", "mine.svg").exit_code == 2
    assert Path("mine.svg").read_text().count('stroke="#b3261e"') == 2
    Path("mine.toml").write_text('base = "paper"\n[pipe]\nradius = -1\n')
    assert call("scenarios", "check", "mine.toml", "--picture", "none.svg").exit_code == 2
    assert not Path("none.svg").exists()
