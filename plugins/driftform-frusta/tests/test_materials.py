"""Materials of hulls by name: what they weigh, and where that is from."""

import re
from pathlib import Path
from typing import get_args

import pytest
from pydantic import ValidationError

from driftform import load_study
from driftform.errors import InputError
from driftform_frusta.builder import FrustaOptions
from driftform_frusta.materials import MATERIALS, find_material

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


def test_a_material_replaces_that_of_a_resolved_study_but_no_density_of_ones_own():
    first = load_study("paper", settings=["builder.material=PETG"], run={"seed": 0})
    assert first.document["builder"]["hull_density"] == 1270.0
    assert FrustaOptions(**{**FrustaOptions(material="PETG").model_dump(), "material": "PLA"}).hull_density == 1240.0
    assert FrustaOptions(hull_density=1111.0).material == "custom"
    with pytest.raises(
        ValidationError, match=r"PETG' has 1270 kg/m3: leave out hull_density, or set material to 'custom'"
    ):
        FrustaOptions(material="PETG", hull_density=1111.0)
    with pytest.raises(InputError, match=r"builder\.material = 'petg': should be 'custom', 'ABS'"):
        load_study("paper", settings=["builder.material=petg"], run={"seed": 0})


@pytest.mark.peers
@pytest.mark.parametrize("name", PROFILES)
def test_densities_are_those_of_the_slicers_profiles(name: str, requires_program) -> None:
    requires_program("prusa-slicer")
    text = Path("/usr/share/PrusaSlicer/profiles/PrusaResearch.ini").read_text(encoding="utf-8")
    found = [
        float(re.search(rf"^\[filament:{re.escape(kind)}\]$[^\[]*?^filament_density = (\S+)", text, re.MULTILINE)[1])
        for kind in PROFILES[name]
    ]
    assert 1000 * min(found) <= MATERIALS[name].density <= 1000 * max(found)
