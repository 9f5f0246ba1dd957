"""``inspect``: an agent's modules, mass, buoyancy, inertia, added mass and warnings."""

import json
import re

import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("ideal_water")

FIGURE_2 = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
"""The word of the paper's Figure 2."""

NATIVE = ("--set", "simulator.use=native")
"""Its flights, from which the sensitivities follow, take less time."""


@pytest.fixture
def facts(call):
    document = json.loads(call("inspect", FIGURE_2, *NATIVE, "--json").stdout)
    return document


def test_inspect_tells_the_modules_of_figure_2_from_aft_to_fore(facts):
    assert [(m["side"], m["length"], m["tilt_deg"]) for m in facts["modules"]] == [
        ("aft", 0.01, pytest.approx(10)),
        ("aft", 0.0025, pytest.approx(-20)),
        ("aft", 0.005, pytest.approx(-10)),
    ]
    assert facts["genome"] == FIGURE_2


def test_inspect_has_the_fields_of_the_contract(facts):
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
def test_net_buoyancy_is_that_of_the_displaced_water_less_the_weight(call, density, gravity):
    settings = ("--set", f"fluid.density={density}", "--set", f"fluid.gravity={gravity}")
    facts = json.loads(call("inspect", FIGURE_2, *NATIVE, "--json", *settings).stdout)
    expected = density * facts["volume"] * gravity - facts["mass"] * gravity
    assert facts["net_buoyancy"] == pytest.approx(expected, rel=1e-12)
    text = call("inspect", FIGURE_2, *NATIVE, *settings).stdout
    assert ("floats" if expected > 0 else "sinks") in text


def test_inspect_prints_the_same_numbers_with_their_units(call, facts):
    text = call("inspect", FIGURE_2, *NATIVE).stdout
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
    assert [line for line in text.splitlines() if line.startswith("warning")] == [
        f"warning: {warning}" for warning in facts["warnings"]
    ]
    assert "kg m2" in text
    assert "kg, kg m, kg m2" in text


def test_inspect_tells_how_the_body_moves(call):
    facts = json.loads(call("inspect", FIGURE_2, *NATIVE, "--json").stdout)
    weight, buoyancy = 9.81 * facts["mass"], 9.81 * 1024 * facts["volume"]
    assert facts["righting_moment"] == pytest.approx(buoyancy * abs(facts["cob"][0] - facts["cog"][0]))
    # It sinks at the speed at which 1/2 rho C_d A v^2 carries its net weight; C_d of a short cylinder is 0.64
    # (White, Re of 1e4) to 0.79 (Hoelzer and Sommerfeld, Re of 2e3), and this body fills three quarters of the rectangle around it.
    across = facts["terminal_speeds"]["across"]
    broadside = 0.5 * 1024 * facts["length"] * facts["max_diameter"] * across**2
    assert (weight - buoyancy) / broadside == pytest.approx(0.75 * 0.715, rel=0.105)
    assert facts["rest"]["slowest_period"] > 0
    assert len(facts["rest"]["eigenvalues"]) == 12


@pytest.mark.long
def test_inspect_compares_the_models_that_are_installed_as_the_study_has_them(call):
    settings = ("--set", "hydrodynamics.m11=volume")
    facts = json.loads(call("inspect", FIGURE_2, *NATIVE, "--json", "--compare", *settings).stdout)
    assert set(facts["compare"]) >= {"striptheory", "panels"}
    assert np.array(facts["compare"]["striptheory"]) == pytest.approx(
        np.array(facts["added_mass"]), rel=1e-9, abs=1e-12
    )
    assert "M55 pitch" in call("inspect", FIGURE_2, *NATIVE, "--compare").stdout
    usual = json.loads(call("inspect", FIGURE_2, *NATIVE, "--json", "--compare").stdout)["compare"]
    assert usual["striptheory"][0][0] != facts["compare"]["striptheory"][0][0]
    assert usual["panels"] == facts["compare"]["panels"]


def warnings_of(call, agent, *settings):
    options = [option for setting in settings for option in ("--set", setting)]
    return "\n".join(json.loads(call("inspect", agent, *NATIVE, "--json", *options).stdout)["warnings"])


@pytest.mark.long
def test_inspect_warns_of_what_is_far_from_neutral(call):
    # Release at the axis of a pipe of 1 m radius: t^2 = 2 (1 m) (m + m_added) / net weight.
    facts = json.loads(call("inspect", FIGURE_2, *NATIVE, "--json").stdout)
    time = np.sqrt(2 * (facts["mass"] + facts["added_mass"][2][2]) / abs(facts["net_buoyancy"]))
    assert f"it sinks from the axis to the wall in {time:.2g} s" in warnings_of(call, FIGURE_2)
    assert "it rises from the axis" in warnings_of(call, FIGURE_2, "builder.core_mass=0.001")
    displaced = 1024 * facts["volume"] - facts["hull_mass"]
    assert "the wall" not in warnings_of(call, FIGURE_2, f"builder.core_mass={displaced}")
    assert "the wall" not in warnings_of(call, FIGURE_2, "fluid.gravity=0")


def test_inspect_warns_of_a_core_denser_than_lead(call):
    # A sphere of 10 mm radius has 4.19 cm3: 47.5 g of lead.
    assert "denser than lead: 11937 kg/m3" in warnings_of(call, FIGURE_2)
    assert "lead" not in warnings_of(call, FIGURE_2, "builder.core_mass=0.047")


def test_inspect_warns_of_what_fits_on_no_common_bed(call):
    long = "-".join(f"addB-tilt{'np'[k % 2]}-1-L-moveB" for k in range(30))
    facts = json.loads(call("inspect", long, *NATIVE, "--json").stdout)
    assert facts["length"] > 0.25
    warning = f"{1000 * facts['length']:.0f} mm long"
    assert warning in warnings_of(call, long) and "bed of a common printer (250 mm)" in warnings_of(call, long)
    assert "bed" not in warnings_of(call, FIGURE_2)
