"""What the check of slender parts advises, made by the kit: cuts that leave no part that sways, and brims that hold."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from driftform.agent import mass_properties
from driftform.interfaces import ExportJob, Printer, PrintJob
from driftform.types import Agent, Coefficients, Module, Morphology
from driftform.water import Scenario
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.exporters.stl import StlExporter
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.kits import make_parts
from driftform_kit.checks.mesh import MeshChecker, MeshOptions
from driftform_kit.sheet.contents import plan_sheet

SLIM = FrustaBuilder(FrustaOptions()).build(
    Morphology((Module(0.02, -math.radians(10)),) * 3 + (Module(0.02, 0.0),) * 5, ())
)
"""A hull with a tip of 27 : 1."""


def job_of(body):
    return ExportJob("agent", Agent(body, mass_properties(body), Coefficients(np.eye(6))), Scenario())


def check_slim(folder, **options):
    """What the check of meshes says of the slender hull, or of its kit, by line and part."""
    job, o = job_of(SLIM), PartOptions(**options)
    files = [f for f in StlExporter(o).write(job, folder / "a.stl") if f.path.endswith(".stl")]
    volume = 1e-9 * sum(file.facts["volume_mm3"] for file in files)
    printing = PrintJob(tuple(Path(file.path) for file in files), Printer(), job, volume)
    found = list(MeshChecker(MeshOptions()).check(printing))
    return {(f.check, f.part.removeprefix("a-")): f for f in found if f.check in ("standing", "slender")}


@pytest.mark.long
@pytest.mark.parametrize("kit", [False, True])
def test_the_cut_that_is_advised_for_a_slender_hull_leaves_parts_that_do_not_sway(tmp_path, kit):
    sways = next(f for f in check_slim(tmp_path, kit=kit).values() if "it sways" in f.detail)
    bed, count = re.search(r"(?:--kit )?--bed ([\d.,]+) makes (\d) that do not", sways.detail).groups()
    assert ("--kit --bed" in sways.detail) != kit
    sides = tuple(float(side) / 1000 for side in bed.split(","))
    cut = {part: f for (check, part), f in check_slim(tmp_path, kit=True, bed=sides).items() if check == "slender"}
    assert len(cut) == int(count) and not any("it sways" in f.detail for f in cut.values())


@pytest.mark.long
def test_a_kit_draws_the_brim_that_is_advised_and_it_holds_the_part(tmp_path):
    bare = check_slim(tmp_path, kit=True)["slender", "fore-shell"].detail
    width = float(re.search(r"lifts it off: print it with a brim of ([\d.]+) mm", bare).group(1))
    drawn = check_slim(tmp_path, kit=True, brim=width / 1000)
    assert "lifts it off" not in drawn["slender", "fore-shell"].detail
    assert "brim" not in drawn["standing", "fore-shell"].detail
    # One layer of a ring round the foot, and only there.
    plain, fore = (make_parts(SLIM, PartOptions(kit=True, brim=b))[1].solid for b in (0.0, width / 1000))
    foot = 3.14
    ring = math.pi * ((foot + width) ** 2 - foot**2) * 0.2
    assert fore.volume - plain.volume == pytest.approx(ring, rel=0.02)
    # What is simulated, weighed and trimmed is the part without it.
    sheets = [plan_sheet(job_of(SLIM), PartOptions(kit=True, brim=b)) for b in (0.0, width / 1000)]
    assert sheets[0].weights == sheets[1].weights


@pytest.mark.long
def test_where_no_cut_helps_the_check_says_so(tmp_path):
    rod = FrustaBuilder(FrustaOptions()).build(Morphology((Module(0.17, 0.0),), ()))
    job = job_of(rod)
    [file] = StlExporter(PartOptions()).write(job, tmp_path / "a.stl")
    printing = PrintJob((Path(file.path),), Printer(), job, 1e-9 * file.facts["volume_mm3"])
    lines = [f.detail for f in MeshChecker(MeshOptions(stiffness=1e8)).check(printing) if f.check == "slender"]
    assert "print it slowly; no joint has room for a cut that helps" in lines[0]
