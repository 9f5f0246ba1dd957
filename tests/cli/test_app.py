"""All commands: a plugin that raises is one line, and an agent opens by file, by run and by text."""

import json
from pathlib import Path

import pytest

FIGURE_2 = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
"""The word of the paper's Figure 2."""


@pytest.mark.usefixtures("ideal_water")
def test_an_agent_opens_by_its_file_by_its_run_and_by_its_text(finished_run, call):
    run = finished_run[0]
    by_file = json.loads(call("inspect", run / "best" / "TP1" / "agent.json", "--json").stdout)
    by_run = json.loads(call("inspect", f"{run}:TP1", "--json").stdout)
    assert by_run.pop("agent") == "run-TP1" and by_file["agent"] == "TP1"
    assert {**by_run, "agent": "TP1"} == by_file
    by_text = json.loads(call("inspect", by_file["genome"], "--json").stdout)
    # A word is flown in the default scenario, which has more targets than the run had.
    assert {**by_text, "agent": "", "sensitivity": {}} == {**by_file, "agent": "", "sensitivity": {}}
    # The rules of a genotype have colons; it is no run, with spaces and without.
    assert "|" in by_file["genome"]
    tight = by_file["genome"].replace(" ", "")
    assert json.loads(call("inspect", tight, "--json").stdout) == by_text


def test_an_agent_keeps_its_body_in_another_scenario(finished_run, call):
    agent = f"{finished_run[0]}:TP1"
    Path("lake.toml").write_text('base = "paper"\n[fluid]\ndensity = 1000.0\n[builder]\nwall = 0.0015\n')
    at_home = json.loads(call("inspect", agent, "--json").stdout)
    away = json.loads(call("inspect", agent, "--scenario", "lake.toml", "--json").stdout)
    assert away["mass"] == at_home["mass"]
    assert away["net_buoyancy"] < at_home["net_buoyancy"]
