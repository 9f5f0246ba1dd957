"""Cores by name: their densities, and options that contradict each other."""

import numpy as np
import pytest
from pydantic import ValidationError

from driftform.agent import mass_properties
from driftform.errors import InputError
from driftform.study import Document, load_study
from driftform.types import Core, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.cores import CORES, DENSITIES, name_core

BALLS_PER_KG = {"steel-10mm": 244, "steel-12mm": 141, "steel-15mm": 72.2, "steel-16mm": 59.5, "steel-20mm": 30.5}
"""Number of bearing balls of 100Cr6 to the kilogram, from the catalogue of a maker (Technoball, ISO 3290)."""

SHEETS = {
    "steel": (7810, 7850),
    "stainless": (7950, 8030),
    "brass": (8400, 8560),
    "tungsten-carbide": (14_850, 15_020),
    "glass": (2400, 2600),
}
"""Range of densities in data sheets, kg/m3."""


@pytest.mark.parametrize("name", BALLS_PER_KG)
def test_a_steel_ball_weighs_what_its_maker_counts(name):
    # The catalogue has three digits.
    assert CORES[name].mass == pytest.approx(1 / BALLS_PER_KG[name], rel=4e-3)


def test_a_steel_ball_of_20_mm_weighs_33_g():
    assert CORES["steel-20mm"] == Core(0.01, pytest.approx(7830 * 4.18879e-6, rel=1e-6))
    assert 0.0327 < CORES["steel-20mm"].mass < 0.0329


def test_densities_are_those_of_data_sheets():
    assert DENSITIES.keys() == SHEETS.keys()
    assert all(low <= DENSITIES[name] <= high for name, (low, high) in SHEETS.items())


def test_the_core_of_the_paper_is_the_default():
    assert FrustaBuilder(FrustaOptions()).build(Morphology()).core == Core(0.01, 0.05)


def test_a_body_has_the_core_that_was_named():
    body = FrustaBuilder(FrustaOptions(core="tungsten-carbide-15mm")).build(Morphology())
    assert body.core == CORES["tungsten-carbide-15mm"]
    assert body.outer[-1, 0] == pytest.approx(0.0075 + 0.0002 + 0.00125)
    assert mass_properties(body).mass > 14_950 * np.pi / 6 * 0.015**3
    assert name_core(body.core) == "tungsten-carbide-15mm" and name_core(Core(0.01, 0.05)) == "custom"


def test_an_unknown_core_is_refused_with_the_names():
    with pytest.raises(ValidationError, match=r"did you mean 'steel-20mm'.*'custom'.*tungsten-carbide.*20, 25, 30 mm"):
        FrustaOptions(core="steal-20mm")


@pytest.mark.parametrize("key, value", [("core_mass", 0.04), ("core_radius", 0.012)])
def test_a_mass_or_a_radius_beside_a_name_is_refused(key, value):
    with pytest.raises(
        ValidationError, match=r"0.032798 kg: leave out core_radius and core_mass, or set core to 'custom'"
    ):
        FrustaOptions(core="steel-20mm", **{key: value})
    assert getattr(FrustaOptions(core="custom", **{key: value}), key) == value


def test_the_core_of_a_resolved_study_can_be_replaced_by_another():
    steel = load_study("paper", settings=['builder.core="steel-20mm"'], run={"seed": 0}).document
    assert steel["builder"]["core_mass"] == CORES["steel-20mm"].mass
    brass = load_study(Document("stored", steel), ['builder.core="brass-16mm"']).document
    assert brass["builder"]["core_radius"] == 0.008
    with pytest.raises(InputError, match=r"--set builder.core_mass=0.1: core 'steel-20mm' has a radius of 0.01 m"):
        load_study(Document("stored", steel), ["builder.core_mass=0.1"])
