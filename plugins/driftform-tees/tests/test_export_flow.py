"""``driftform export-flow``: the current of a study as a file, and what is refused."""

import json
from pathlib import Path

import pytest


def test_the_file_that_was_told_of_is_there_and_can_be_flown_in(call):
    result = call("export-flow", "paper", "--spacing", "0.25", "--out", "c.csv", "--json")
    assert result.exit_code == 0, result.stderr
    told = json.loads(result.stdout)
    assert told["file"] == "c.csv" and told["speed"] == 1.0 and told["warnings"] == []
    lines = Path("c.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "timestamp,x,y,z,u,v,w"
    assert len(lines) == told["nodes"] + 1
    checked = call("scenarios", "check", "paper", "--set", "flow={kind='grid',file='c.csv',speed=1.0}")
    assert checked.exit_code == 0, checked.stderr


def test_gusts_that_are_left_out_are_told_of(call):
    flow = "flow={kind='turbulent',speed=1.0}"
    result = call("export-flow", "paper", "--spacing", "0.4", "--set", flow, "--out", "c.csv")
    assert result.exit_code == 0, result.stderr
    assert "warning: gusts are left out" in result.stdout
    assert 'flow.kind = "grid", flow.file = "c.csv", flow.reference = 1' in result.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("paper", "--out", "c.vtk"), "choose a name that ends in .csv"),
        (("paper", "--spacing", "3"), "choose at most 0.5 m"),
        (("paper", "--spacing", "0"), "must be positive"),
        (("t-junction", "--spacing", "0.001"), "choose at least"),
    ],
)
def test_what_cannot_be_written_is_refused(arguments, words, refused):
    assert words in refused("export-flow", *arguments)
    assert not list(Path().glob("*.csv"))
