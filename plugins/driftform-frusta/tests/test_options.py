"""Options of bodies and kits: cores and materials by name, and what contradicts itself."""

import re
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from pydantic import ValidationError

from driftform.agent import mass_properties
from driftform.errors import InputError
from driftform.study import Document, load_study
from driftform.types import Core, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.cores import CORES, DENSITIES, name_core
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.materials import MATERIALS, find_material


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"o_ring": 0.0015, "joint": "rabbet"}, "rabbet has no room for an O-ring"),
        ({"joint": "bayonet", "clearance": 0.0005}, "set clearance to 0.0004 or less, or joint to 'auto'"),
        ({"clearance": 0.0}, "clearance"),
        ({"joint": "screw"}, "joint"),
        ({"bed": (0.2, 0.2)}, "bed"),
        ({"bed": (0.2, 0.2, 0.0)}, "bed"),
        ({"engrave": "TP5"}, "engrave"),
    ],
)
def test_what_contradicts_itself_is_refused(options, why):
    with pytest.raises(ValidationError, match=why):
        PartOptions(**options)


CAPSULE = {"core_profile": ((0, 0), (0.01, 0.01), (0.02, 0)), "core_cog": 0.01}
BESIDE_A_NAME = "0.032798 kg: leave out core_radius and core_mass, or set core to 'custom'"


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"wall": 0.002}, "min_radius 0.0025 m must exceed 1.5 times the wall"),
        ({"max_radius": 0.011, "core": "steel-20mm"}, r"less than core, clearance and wall, 0\.01145 m"),
        ({"core": "steal-20mm"}, "did you mean 'steel-20mm'.*'custom'.*tungsten-carbide.*20, 25, 30 mm"),
        ({"core": "x"}, "core 'x' is not known; there are 'custom', and balls of steel"),
        ({"core": "steel-20mm", "core_mass": 0.04}, BESIDE_A_NAME),
        ({"core": "steel-20mm", "core_radius": 0.012}, BESIDE_A_NAME),
        ({"core_cog": 0.01}, "core_cog' is for a capsule"),
        (CAPSULE | {"core_cog": None}, "core_cog is missing"),
        (CAPSULE | {"core_radius": 0.02}, "leave it out"),
        (CAPSULE | {"core_profile": ((0, 0), (0.01, 0), (0.02, 0))}, "core_profile must run from the nose"),
        ({"material": "PETG", "hull_density": 1111.0}, "leave out hull_density, or set material to 'custom'"),
        (
            {"pressure": 1e5, "hull_density": 1111.0},
            "the strength of a material of 1111 kg/m3 is not known: set material",
        ),
        ({"pressure": 1e5, "wall_model": "paper"}, "wall_model 'paper' withstands no pressure, as its ends are open"),
        ({"pockets": {"diameter": 0.005}, "wall_model": "paper"}, "open ends, which take no trim pockets"),
        ({"kit": {"joint": "sleeve"}}, "made_as is 'hull': set made_as to 'kit'"),
        ({"made_as": "kit", "wall_model": "paper"}, "open ends of wall_model 'paper'"),
        ({"made_as": "kit", "kit": {"ballast": [[0.04, 0.006]]}}, "set it for the exporter"),
    ],
)
def test_options_of_a_body_that_contradict_each_other_are_refused(options, why):
    with pytest.raises(ValidationError, match=why):
        FrustaOptions.model_validate(options)


def test_options_of_older_runs_that_engraved_nothing_are_taken():
    assert PartOptions(engrave="", engrave_depth=0.0004) == PartOptions()


def test_a_second_ball_of_ballast_is_refused_with_what_to_do():
    with pytest.raises(ValueError, match="a kit holds one ball, not 2: replace them by one of their mass"):
        PartOptions(kit=True, ballast=[[-0.04, 0.006], [0.045, 0.008]])


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


def test_the_core_of_a_resolved_study_can_be_replaced_by_another():
    steel = load_study("paper", settings=['builder.core="steel-20mm"'], run={"seed": 0}).document
    assert steel["builder"]["core_mass"] == CORES["steel-20mm"].mass
    brass = load_study(Document("stored", steel), ['builder.core="brass-16mm"']).document
    assert brass["builder"]["core_radius"] == 0.008
    with pytest.raises(InputError, match=r"--set builder.core_mass=0.1: core 'steel-20mm' has a radius of 0.01 m"):
        load_study(Document("stored", steel), ["builder.core_mass=0.1"])


PROFILES = {
    "ABS": ("Generic ABS", "Filament PM ABS"),
    "ASA": ("Prusament ASA", "Fillamentum ASA"),
    "PLA": ("Generic PLA", "Prusament PLA"),
    "PETG": ("Generic PETG", "Prusament PETG"),
    "PA12": ("Fiberlogy Nylon PA12",),
}
"""Filaments of PrusaSlicer's profiles that are of each material."""


def test_every_material_can_be_named_in_a_study_and_found_by_its_density():
    options = get_args(FrustaOptions.model_fields["material"].annotation)
    assert options == ("custom", *MATERIALS)
    for name, material in MATERIALS.items():
        assert FrustaOptions(material=name).hull_density == material.density
        assert find_material(material.density) == name and material.source
    assert find_material(1127.5) is None


def test_the_numbers_of_a_material_are_those_of_a_stiff_plastic_and_each_has_a_source():
    for material in MATERIALS.values():
        assert 0.5e9 < material.modulus < 4e9 and 0 < material.poisson < 0.5
        assert material.across <= material.strength < 80e6, "layers are no stronger than the plastic"
        # Moulded bars yield at 1 to 4 %: Terluran GP-35 2.4 %, Luran S 778T 3.4 %.
        assert 0.005 < material.across / material.modulus < 0.05
        assert 0.2 < material.creep < 1 and 30e-6 < material.expansion < 200e-6 and 0 < material.absorption < 0.05
        assert all(
            f"{word}" in material.mechanics.lower() for word in ("mpa", "creep", "poisson", "expansion", "water:")
        )


def test_a_material_replaces_that_of_a_resolved_study_but_not_your_own_density():
    first = load_study("paper", settings=["builder.material=PETG"], run={"seed": 0})
    assert first.document["builder"]["hull_density"] == 1270.0
    assert FrustaOptions(**{**FrustaOptions(material="PETG").model_dump(), "material": "PLA"}).hull_density == 1240.0
    assert FrustaOptions(hull_density=1111.0).material == "custom"
    with pytest.raises(InputError, match=r"builder\.material = 'petg': should be 'custom', 'ABS'"):
        load_study("paper", settings=["builder.material=petg"], run={"seed": 0})


@pytest.mark.peers
@pytest.mark.parametrize("name", PROFILES)
def test_densities_are_those_of_the_slicers_profiles(name, requires_program):
    requires_program("prusa-slicer")
    text = Path("/usr/share/PrusaSlicer/profiles/PrusaResearch.ini").read_text(encoding="utf-8")
    found = [
        float(re.search(rf"^\[filament:{re.escape(kind)}\]$[^\[]*?^filament_density = (\S+)", text, re.MULTILINE)[1])
        for kind in PROFILES[name]
    ]
    assert 1000 * min(found) <= MATERIALS[name].density <= 1000 * max(found)
