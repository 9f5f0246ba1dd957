"""``simulate``: one flight, printed and written."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("ideal_water")

FIGURE_2 = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
"""The word of the paper's Figure 2."""


@pytest.mark.parametrize(("words", "simulator"), [((), "native"), (("--set", "simulator.use=exudyn"), "exudyn")])
def test_simulate_has_the_fields_of_the_contract_and_writes_the_flight(call, words, simulator):
    result = call("simulate", FIGURE_2, "--json", "--out", "flight", "--set", "flight.horizon=1.5", *words)
    assert result.exit_code == 0, result.stderr
    document = json.loads(result.stdout)
    assert list(document["fitness"]) == [f"TP{n}" for n in range(1, 11)]
    assert document["end"]["reason"] == "horizon"
    assert document["end"]["t"] == pytest.approx(1.5)
    assert document["simulator"] == simulator
    table = np.loadtxt(document["trajectory"], delimiter=",", skiprows=1)
    assert document["trajectory"] == str(Path("flight", "trajectory.csv"))
    assert table[-1, 0] == pytest.approx(document["end"]["t"], rel=1e-6)
    assert table[-1, 1:4] == pytest.approx(document["end"]["position"], rel=1e-6)
    assert Path("flight", "flight.svg").is_file()


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--style", "papr"), "--style papr: no such style; did you mean 'paper'?"),
        (("--width-mm", "85"), "--width-mm 85: pictures for the screen have no width in mm; add --style paper"),
    ],
)
def test_a_style_that_cannot_be_is_refused_before_the_flight(call, options, line):
    result = call("simulate", FIGURE_2, *options)
    assert (result.exit_code, result.stderr) == (2, f"error: {line}\n")
    assert not Path("flights").exists()


def test_simulate_without_targets_flies_all_the_same(call):
    settings = ("--set", "targets={}", "--set", "flight.horizon=0.5")
    result = call("simulate", FIGURE_2, "--json", *settings)
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["fitness"] == {}
    assert call("simulate", FIGURE_2, *settings).exit_code == 0


def test_a_plugin_of_the_command_line_takes_the_place_of_that_of_the_agent(finished_run, call, fakes):
    document = json.loads(call("simulate", f"{finished_run[0]}:TP1", "--simulator", "fake", "--json").stdout)
    assert document["simulator"] == "fake"
    assert document["end"]["reason"] == "outlet"


def test_inspect_warns_of_added_mass_that_lagging_simulators_cannot_take(call):
    light = call("inspect", FIGURE_2, "--json", "--set", "builder.core_mass=0.001", "--set", "builder.hull_density=20")
    facts = json.loads(light.stdout)
    assert facts["lambda_max"] > 17 / 3
    assert any("diverge" in warning for warning in facts["warnings"])


def test_simulate_and_export_flight_say_how_much_of_a_bore_a_body_fills_if_this_is_too_much(call):
    for radius, count in ((1.0, 0), (0.03, 1)):
        pipe = f"pipe.segments=[{{start = [0, 0, 0], end = [9, 0, 0], radius = {radius}}}]"
        settings = ("--set", pipe, "--set", "targets={}", "--set", "flight.horizon=0.1")
        flown = call("simulate", FIGURE_2, "--json", "--out", "flight", *settings)
        found = [line for line in json.loads(flown.stdout)["warnings"] if line.startswith("a body in a bore: ")]
        assert len(found) == count, flown.stderr
        told = [flown.stderr, call("export-flight", FIGURE_2, *settings).stderr]
        assert all("; it holds from 0 to 0.3" in line for line in found)
        assert all(f"warning: {line}" in text for line in found for text in told)


def test_disturbed_flights_through_a_junction_are_counted_by_outlet(call):
    shutil.copy(Path(__file__).with_name("junction.toml"), "junction.toml")
    arguments = ("simulate", FIGURE_2, "--scenario", "junction.toml", "--robust", 3)
    told = json.loads(call(*arguments, "--json").stdout)
    shares = told["disturbed_outlets"]
    assert list(shares) == ["up", "on"]
    assert all(3 * share == pytest.approx(round(3 * share)) for share in shares.values())
    assert sum(shares.values()) <= 1 + 1e-9
    # Who leaves by an outlet has passed it within its bore; who passed it may lie there still when the time is over.
    for target, outlet, bore in (("branch", "up", 0.05), ("main", "on", 0.1)):
        passed = [d < bore for d in told["disturbed"][target]["distances"]]
        assert shares[outlet] <= sum(passed) / 3 + 1e-9
    assert max(shares.values()) > 0
    shown = call(*arguments).stdout
    lines = [line.split() for line in shown.splitlines()]
    assert ["up", f"{100 * shares['up']:.0f}"] in lines and ["on", f"{100 * shares['on']:.0f}"] in lines
