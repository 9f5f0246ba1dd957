"""An eyelet weighs the same in simulation, files, sheet, balance and check, and stays out of the way of a kit."""

import json
from pathlib import Path

import pytest
from prints import chain_body

from driftform import open_agent
from driftform.agent import MassElement, hull_mass, mass_properties
from driftform.errors import WorkFailedError
from driftform_frusta.csg import Revolve, Rotate, Translate
from driftform_frusta.eyelet import Eyelet, EyeletOptions
from driftform_frusta.fittings import fit_hull
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import make_parts
from driftform_kit.cutting.pieces import make_kit
from driftform_kit.reading import read_meshes
from driftform_kit.sheet.contents import plan_sheet

WORD = "-".join(["addF-tiltp-0-L-moveF"] * 3 + ["addB-tiltn-1-L-moveB"] * 2)
EYELET = 'builder.fittings=[{use = "eyelet", end = "fore", diameter = 0.012, aside = 0.005}]'
GRAM = 1e-5
"""A hundredth of a gram, kg."""


@pytest.mark.parametrize("made", ["hull", "kit"])
def test_simulation_files_sheet_balance_and_check_agree_to_a_hundredth_of_a_gram(made, call, tmp_path):
    design = open_agent(WORD, f"builder.made_as={made}", EYELET)
    body, simulated = design.agent.body, mass_properties(design.agent.body)
    putty = sum(MassElement.of_putty(pocket).mass for pocket in body.pockets)
    printed = simulated.mass - body.core.mass - body.ballast.volume * body.ballast_density - putty
    for name in ("stl", "3mf", "obj"):
        files = design.under(f"exporter.{name}.kit={str(made == 'kit').lower()}").export_files(
            name, tmp_path / f"{made}.{name}"
        )
        meshes = [mesh for file in files if file.path.endswith(name) for mesh in read_meshes(Path(file.path))]
        assert 1e-9 * body.hull_density * sum(mesh.volume for mesh in meshes) == pytest.approx(printed, abs=GRAM)
    if made == "kit":
        facts = files[0].facts["kit"]
        assert [row["mass_kg"] for row in facts["balance"]] == pytest.approx(
            [simulated.mass, simulated.mass - putty, simulated.mass], abs=GRAM
        )
        sheet = plan_sheet(design.export_job(), PartOptions(kit=True))
        assert sum(part.mass for part in sheet.parts) == pytest.approx(printed, abs=GRAM)
        [(_, told)] = [row for row in sheet.settings if row[0] == "eyelet"]
        gained = hull_mass(body) - hull_mass(open_agent(WORD, f"builder.made_as={made}").agent.body)
        assert float(told.removesuffix(" g")) == pytest.approx(1000 * gained, abs=0.01)
    arguments = ("check", WORD, "--set", f"builder.made_as={made}", "--set", EYELET, "--no-programs", "--json")
    lines = json.loads(call(*arguments, *(["--kit"] if made == "kit" else [])).stdout)["lines"]
    [weighed] = [line for line in lines if line["check"] == "mass"]
    assert weighed["state"] == "pass"
    assert float(weighed["detail"].split(" g at ")[0].split()[-1]) == pytest.approx(1000 * printed, abs=0.01)


def test_the_part_with_an_eyelet_stands_on_its_other_end():
    body = fit_hull(chain_body("sss", "sss"), [Eyelet(EyeletOptions(end="fore")), Eyelet(EyeletOptions(end="aft"))])
    assert [part.fore_down for part in make_parts(body, PartOptions(kit=True))] == [True, False]


@pytest.mark.parametrize(("share", "message"), [(0.0, "boss lies across a joint"), (0.6, "meets")])
def test_a_boss_in_the_way_of_a_joint_is_refused(share, message):
    hull = chain_body("ssss", "ssss")
    joint = make_kit(hull, PartOptions(kit=True)).core_joint
    z = joint.z + share * (joint.tip - joint.z)

    class Boss(Eyelet):
        name = "boss"

        def draw(self, body):
            upright = Revolve(((0.0, 9.5), (2.0, 9.5), (2.0, 12.5), (0.0, 12.5)))
            return Translate((0.0, 0.0, z), Rotate((0.0, 90.0, 0.0), upright)), None

    body = fit_hull(hull, [Boss(EyeletOptions())])
    with pytest.raises(WorkFailedError, match=message):
        make_parts(body, PartOptions(kit=True))
