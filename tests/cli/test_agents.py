"""``inspect``, ``simulate``, ``sample`` and ``export``: their JSON fields, their units, and that they agree."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

FIGURE_2 = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
"""The word of the paper's Figure 2."""

Call = Callable[..., Any]


@pytest.fixture
def facts(call: Call) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(call("inspect", FIGURE_2, "--json").stdout)
    return document


def test_inspect_tells_the_modules_of_figure_2_from_aft_to_fore(facts: dict[str, Any]) -> None:
    assert [(m["side"], m["length"], m["tilt_deg"]) for m in facts["modules"]] == [
        ("aft", 0.01, pytest.approx(10)),
        ("aft", 0.0025, pytest.approx(-20)),
        ("aft", 0.005, pytest.approx(-10)),
    ]
    assert facts["genome"] == FIGURE_2


def test_inspect_has_the_fields_of_the_contract(facts: dict[str, Any]) -> None:
    assert facts["length"] > facts["modules"][0]["length"]
    assert 0.02 < facts["max_diameter"] < 0.03
    assert facts["mass"] == pytest.approx(facts["hull_mass"] + facts["core_mass"])
    assert np.shape(facts["cog"]) == np.shape(facts["cob"]) == np.shape(facts["added_mass_origin"]) == (3,)
    inertia, added = np.array(facts["inertia"]), np.array(facts["added_mass"])
    assert inertia.shape == (3, 3)
    assert (np.linalg.eigvalsh(inertia) > 0).all()
    assert added.shape == (6, 6)
    assert (np.linalg.eigvalsh(added) > -1e-12).all()
    assert facts["hydrodynamics"] == "striptheory"
    assert any("denser than lead" in warning for warning in facts["warnings"])


@pytest.mark.parametrize(("density", "gravity"), [(1024.0, 9.81), (1.0, 9.81), (20_000.0, 1.62)])
def test_net_buoyancy_is_that_of_the_displaced_water_less_the_weight(
    call: Call, density: float, gravity: float
) -> None:
    settings = ("--set", f"fluid.density={density}", "--set", f"fluid.gravity={gravity}")
    facts = json.loads(call("inspect", FIGURE_2, "--json", *settings).stdout)
    expected = density * facts["volume"] * gravity - facts["mass"] * gravity
    assert facts["net_buoyancy"] == pytest.approx(expected, rel=1e-12)
    text = call("inspect", FIGURE_2, *settings).stdout
    assert ("floats" if expected > 0 else "sinks") in text


def test_inspect_prints_the_same_numbers_with_their_units(call: Call, facts: dict[str, Any]) -> None:
    text = call("inspect", FIGURE_2).stdout
    printed = {
        "length": (facts["length"], 1e3, "mm"),
        "largest diameter": (facts["max_diameter"], 1e3, "mm"),
        "mass": (facts["mass"], 1e3, "g"),
        "displaced volume": (facts["volume"], 1e6, "cm3"),
        "net buoyancy": (facts["net_buoyancy"], 1.0, "N"),
        "centre of gravity": (facts["cog"][0], 1e3, "mm"),
        "centre of buoyancy": (facts["cob"][0], 1e3, "mm"),
    }
    for label, (value, scale, unit) in printed.items():
        match = re.search(rf"^{label} +(?:x )?([-+.\d]+) (\w+)", text, re.MULTILINE)
        assert match, label
        assert float(match[1]) == pytest.approx(value * scale, abs=0.006)
        assert match[2] == unit
    assert "kg m2" in text
    assert "kg, kg m, kg m2" in text


def test_an_agent_opens_by_its_file_by_its_run_and_by_its_text(
    finished_run: tuple[Path, Any], call: Call
) -> None:
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


def test_a_run_in_a_directory_with_a_space_opens(run_copy: Path, call: Call) -> None:
    run_copy.rename("my run")
    assert call("inspect", "my run:TP1").exit_code == 0


def test_simulate_has_the_fields_of_the_contract_and_writes_the_flight(call: Call) -> None:
    result = call("simulate", FIGURE_2, "--json", "--out", "flight", "--set", "flight.horizon=1.5")
    assert result.exit_code == 0, result.stderr
    document = json.loads(result.stdout)
    assert list(document["fitness"]) == [f"TP{n}" for n in range(1, 11)]
    assert document["end"]["reason"] == "horizon"
    assert document["end"]["t"] == pytest.approx(1.5)
    assert document["simulator"] == "exudyn"
    table = np.loadtxt(document["trajectory"], delimiter=",", skiprows=1)
    assert document["trajectory"] == str(Path("flight", "trajectory.csv"))
    assert table[-1, 0] == pytest.approx(document["end"]["t"], rel=1e-6)
    assert table[-1, 1:4] == pytest.approx(document["end"]["position"], rel=1e-6)
    assert Path("flight", "flight.svg").is_file()


def test_simulate_without_targets_flies_all_the_same(call: Call) -> None:
    settings = ("--set", "targets={}", "--set", "flight.horizon=0.5")
    result = call("simulate", FIGURE_2, "--json", *settings)
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["fitness"] == {}
    assert call("simulate", FIGURE_2, *settings).exit_code == 0


@pytest.mark.parametrize("command", ["inspect", "simulate", "export"])
def test_a_builder_that_raises_is_told_in_one_line(
    call: Call, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def build(*_: object) -> None:
        raise FloatingPointError("no wall is left")

    monkeypatch.setattr("driftform_frusta.builder.FrustaBuilder.build", build)
    result = call(command, FIGURE_2)
    assert isinstance(result.exception, SystemExit)
    assert result.exit_code == 1
    [line] = result.stderr.splitlines()
    assert "cannot be built: FloatingPointError: no wall is left" in line


def test_a_simulator_that_raises_is_told_in_one_line(call: Call, fakes: None) -> None:
    result = call("simulate", FIGURE_2, "--simulator", "fake", "--set", "simulator.fail=1")
    assert result.exit_code == 1
    [line] = result.stderr.splitlines()
    assert re.fullmatch(r"error: word-\w+: cannot be flown: RuntimeError: genome .* not to my taste", line)


def test_simulate_prints_where_and_why_the_flight_ended(call: Call) -> None:
    text = call("simulate", FIGURE_2, "--set", "flight.horizon=0.5").stdout
    assert re.search(r"ended at the horizon after 0\.500 s at x 0\.\d+, y .*, z .* m", text)


def test_a_plugin_of_the_command_line_takes_the_place_of_that_of_the_agent(
    finished_run: tuple[Path, Any], call: Call, fakes: None
) -> None:
    document = json.loads(call("simulate", f"{finished_run[0]}:TP1", "--simulator", "fake", "--json").stdout)
    assert document["simulator"] == "fake"
    assert document["end"]["reason"] == "outlet"


def test_an_agent_keeps_its_body_in_another_scenario(finished_run: tuple[Path, Any], call: Call) -> None:
    agent = f"{finished_run[0]}:TP1"
    Path("lake.toml").write_text(
        'base = "pipe-inspection"\n[fluid]\ndensity = 1000.0\n[builder]\nwall = 0.0015\n'
    )
    at_home = json.loads(call("inspect", agent, "--json").stdout)
    away = json.loads(call("inspect", agent, "--scenario", "lake.toml", "--json").stdout)
    assert away["mass"] == at_home["mass"]
    assert away["net_buoyancy"] < at_home["net_buoyancy"]


def test_samples_are_those_of_their_seed(call: Call) -> None:
    for out, seed in (("a", 3), ("b", 3), ("c", 4)):
        document = json.loads(call("sample", "--count", 3, "--seed", seed, "--out", out, "--json").stdout)
        assert document["agents"] == [str(Path(out, f"agent-000{n}.json")) for n in (1, 2, 3)]
    texts = {out: [Path(out, f"agent-000{n}.json").read_text() for n in (1, 2, 3)] for out in ("a", "b", "c")}
    assert texts["a"] == texts["b"]
    assert len({*texts["a"], *texts["c"]}) == 6


def test_more_samples_begin_with_the_same_ones(call: Call) -> None:
    call("sample", "--count", 2, "--out", "few")
    call("sample", "--count", 5, "--out", "many")
    for name in ("agent-0001.json", "agent-0002.json"):
        assert Path("few", name).read_text() == Path("many", name).read_text()


def test_a_sample_can_be_inspected_and_exported(call: Call) -> None:
    call("sample", "--count", 1, "--out", "out")
    assert call("inspect", "out/agent-0001.json").exit_code == 0
    result = call("export", "out/agent-0001.json", "--out", "parts")
    assert result.exit_code == 0
    assert result.stdout.startswith(str(Path("parts", "agent-0001.stl")))


def test_export_writes_the_formats_it_names(call: Call) -> None:
    result = call("export", FIGURE_2, "--format", "stl, scad", "--out", "parts", "--json")
    assert result.exit_code == 0, result.stderr
    files = json.loads(result.stdout)["files"]
    assert [file["format"] for file in files] == ["stl", "scad"]
    facts = json.loads(call("inspect", FIGURE_2, "--json").stdout)
    mesh = trimesh.load_mesh(files[0]["path"])
    assert mesh.is_watertight
    assert mesh.extents[2] == pytest.approx(1e3 * facts["length"], rel=1e-5)
    for file in files:
        assert file["mass_kg"] == pytest.approx(facts["hull_mass"], rel=1e-6)
    assert "rotate_extrude" in Path(files[1]["path"]).read_text()


def test_inspect_tells_how_the_body_moves(call: Call) -> None:
    facts = json.loads(call("inspect", FIGURE_2, "--json").stdout)
    weight, buoyancy = 9.81 * facts["mass"], 9.81 * 1024 * facts["volume"]
    assert facts["righting_moment"] == pytest.approx(buoyancy * abs(facts["cob"][0] - facts["cog"][0]))
    # It sinks at the speed at which 1/2 rho C_d A v^2 carries its net weight; C_d of a short cylinder is 0.64, and
    # this body fills three quarters of the rectangle around it.
    across = facts["terminal_speeds"]["across"]
    broadside = 0.5 * 1024 * facts["length"] * facts["max_diameter"] * across**2
    assert (weight - buoyancy) / broadside == pytest.approx(0.75 * 0.64, rel=0.1)
    assert facts["rest"]["slowest_period"] > 0
    assert len(facts["rest"]["eigenvalues"]) == 12


def test_inspect_compares_all_models_about_one_point(call: Call) -> None:
    facts = json.loads(call("inspect", FIGURE_2, "--json", "--compare").stdout)
    assert "striptheory" in facts["compare"]
    ours = np.array(facts["compare"]["striptheory"])
    assert ours == pytest.approx(np.array(facts["added_mass"]), rel=1e-9, abs=1e-12)
    text = call("inspect", FIGURE_2, "--compare").stdout
    assert "M55 pitch" in text


def test_inspect_warns_of_added_mass_that_lagging_simulators_cannot_take(call: Call) -> None:
    light = call(
        "inspect", FIGURE_2, "--json", "--set", "builder.core_mass=0.001", "--set", "builder.hull_density=20"
    )
    facts = json.loads(light.stdout)
    assert facts["lambda_max"] > 17 / 3
    assert any("diverge" in warning for warning in facts["warnings"])


def test_inspect_compares_the_models_that_are_installed_as_the_study_has_them(call: Call) -> None:
    settings = ("--set", "hydrodynamics.m11=volume")
    facts = json.loads(call("inspect", FIGURE_2, "--json", "--compare", *settings).stdout)
    assert set(facts["compare"]) >= {"striptheory", "panels"}
    assert facts["compare"]["striptheory"][0][0] == pytest.approx(facts["added_mass"][0][0])
    usual = json.loads(call("inspect", FIGURE_2, "--json", "--compare").stdout)["compare"]
    assert usual["striptheory"][0][0] != facts["compare"]["striptheory"][0][0]
    assert usual["panels"] == facts["compare"]["panels"]


def warnings_of(call: Call, agent: str, *settings: str) -> str:
    options = [option for setting in settings for option in ("--set", setting)]
    found = json.loads(call("inspect", agent, "--json", *options).stdout)["warnings"]
    text = call("inspect", agent, *options).stdout
    assert [line for line in text.splitlines() if line.startswith("warning")] == [
        f"warning: {w}" for w in found
    ]
    return "\n".join(found)


def test_inspect_warns_of_what_is_far_from_neutral(call: Call) -> None:
    # Release at the axis of a pipe of 1 m radius: t^2 = 2 (1 m) (m + m_added) / net weight.
    facts = json.loads(call("inspect", FIGURE_2, "--json").stdout)
    time = np.sqrt(2 * (facts["mass"] + facts["added_mass"][2][2]) / abs(facts["net_buoyancy"]))
    assert f"it sinks from the axis to the wall in {time:.2g} s" in warnings_of(call, FIGURE_2)
    assert "it rises from the axis" in warnings_of(call, FIGURE_2, "builder.core_mass=0.001")
    displaced = 1024 * facts["volume"] - facts["hull_mass"]
    assert "the wall" not in warnings_of(call, FIGURE_2, f"builder.core_mass={displaced}")
    assert "the wall" not in warnings_of(call, FIGURE_2, "fluid.gravity=0")


def test_inspect_warns_of_a_core_denser_than_lead(call: Call) -> None:
    # A sphere of 10 mm radius has 4.19 cm3: 47.5 g of lead.
    assert "denser than lead: 11937 kg/m3" in warnings_of(call, FIGURE_2)
    assert "lead" not in warnings_of(call, FIGURE_2, "builder.core_mass=0.047")


def test_inspect_warns_of_what_fits_on_no_common_bed(call: Call) -> None:
    long = "-".join(f"addB-tilt{'np'[k % 2]}-1-L-moveB" for k in range(30))
    facts = json.loads(call("inspect", long, "--json").stdout)
    assert facts["length"] > 0.25
    warning = f"{1000 * facts['length']:.0f} mm long"
    assert warning in warnings_of(call, long) and "bed of a common printer (250 mm)" in warnings_of(
        call, long
    )
    assert "bed" not in warnings_of(call, FIGURE_2)
