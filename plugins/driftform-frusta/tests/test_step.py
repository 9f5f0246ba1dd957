"""STEP files: exact solids, read back by Open CASCADE."""

import builtins
import math
import re
from pathlib import Path

import numpy as np
import pytest
from prints import job_of

from driftform.errors import WorkFailedError
from driftform_frusta.brep import to_brep, volume_of
from driftform_frusta.csg import Difference, Extrude, Intersection, Revolve, Translate, Union
from driftform_frusta.exporters.step import StepExporter
from driftform_frusta.hull import hull_volume
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import make_parts
from driftform_frusta.solid import to_solid

pytestmark = pytest.mark.peers


def bounds_of(shape):
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    low, high = box.CornerMin(), box.CornerMax()
    return (low.X(), low.Y(), low.Z(), high.X(), high.Y(), high.Z())


def read(path):
    """The products of a STEP file: name, shape, and bounds in mm."""
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader()
    assert reader.ReadFile(str(path)) == IFSelect_RetDone
    reader.TransferRoots()
    shapes = [reader.Shape(i) for i in range(1, reader.NbShapes() + 1)]
    names = re.findall(r"= PRODUCT\('([^']*)'", Path(path).read_text(encoding="utf-8"))
    return [(name, shape, bounds_of(shape)) for name, shape in zip(names, shapes, strict=True)]


@pytest.fixture
def write(tmp_path):
    def written(body, **options):
        return StepExporter(PartOptions(**options)).write(job_of(body, "hull"), tmp_path / "hull.step")[0]

    return written


def test_a_hull_read_back_has_exactly_the_volume_and_size_of_the_body(body, write):
    file = write(body)
    [(name, shape, bounds)] = read(file.path)
    assert name == "hull"
    assert volume_of(shape) == pytest.approx(1e9 * hull_volume(body), rel=1e-9)
    radius = 500 * body.max_diameter
    expected = (-radius, -radius, 0, radius, radius, 1000 * body.length)
    assert bounds == pytest.approx(expected, abs=1e-4)
    assert file.facts["size_mm"] == pytest.approx(np.subtract(expected[3:], expected[:3]))


def test_faces_are_cones_cylinders_and_planes_and_no_facets(wavy_body, write):
    file = write(wavy_body, segments=12)
    text = Path(file.path).read_text(encoding="utf-8")
    # A closed conical face is one, whatever the segments of a mesh would be.
    edges = sum(len(c) - 1 for c in (wavy_body.outer, wavy_body.cavity))
    assert file.facts["faces"] <= edges
    kinds = {
        kind: len(re.findall(rf"= {kind}\(", text)) for kind in ("CONICAL_SURFACE", "CYLINDRICAL_SURFACE", "PLANE")
    }
    assert sum(kinds.values()) == file.facts["faces"]
    assert kinds["CONICAL_SURFACE"] > 70
    assert "AP242" in text


def test_a_kit_is_written_as_its_parts_by_name_where_they_are_joined(write, make_chain):
    body = make_chain([0.03, 0.03, 0.03], [0.012, 0.016, 0.016, 0.012])
    parts = make_parts(body, PartOptions(kit=True, segments=512))
    found = read(write(body, kit=True).path)
    assert [name for name, _, _ in found] == [part.name for part in parts]
    for (_, shape, bounds), part in zip(found, parts, strict=True):
        assert volume_of(shape) == pytest.approx(part.solid.volume, rel=1e-6)
        assert np.allclose(bounds, part.solid.bounds.ravel(), atol=2e-3)


def frustum(height, r0, r1):
    return Revolve(((0, 0), (r0, 0), (r1, height), (0, height)))


CAN, VOLUME = frustum(4, 3, 3), 36 * math.pi


@pytest.mark.parametrize(
    ("tree", "volume"),
    [
        (frustum(7, 3, 5), math.pi * 7 * (9 + 15 + 25) / 3),
        (frustum(7, 0, 5), math.pi * 7 * 25 / 3),
        (Revolve(((5, 0), (9, 0), (9, 6), (5, 6)), (((6, 1), (8, 1), (8, 3), (6, 3)),)), 280 * math.pi),
        (Revolve(((-3, 0), (5, 0), (5, 7), (-4, 7))), math.pi * 25 * 7),
        (Translate((9, 9, 9), CAN), VOLUME),
        (Difference(CAN, (Translate((0, 0, -1), frustum(9, 2, 2)),)), 20 * math.pi),
        (Intersection((CAN, Translate((0, 0, 2), CAN))), VOLUME / 2),
        (Union((CAN, Translate((0, 0, 10), CAN))), 2 * VOLUME),
        (Extrude(((0, 0), (9, 0), (0, 6)), (((1, 1), (2, 1), (1, 3)),), 2.0), 52),
    ],
)
def test_every_kind_of_solid_has_exactly_its_volume(tree, volume):
    assert volume_of(to_brep(tree)) == pytest.approx(volume, rel=1e-9)


def test_a_section_that_winds_round_sweeps_its_area_times_the_way_of_its_middle():
    winding = Revolve(((8, 0), (9, 0), (9, 1), (8, 1)), (), 720.0, 4.0)
    assert volume_of(to_brep(winding)) == pytest.approx(34 * math.pi, rel=1e-5)
    assert to_solid(winding, 96).volume == pytest.approx(34 * math.pi, rel=1e-3)


def test_nothing_is_printed_on_the_way(wavy_body, write, capfd):
    write(wavy_body)
    assert capfd.readouterr() == ("", "")


def test_without_open_cascade_one_line_says_how_to_get_it(wavy_body, write, monkeypatch, tmp_path):
    real = builtins.__import__

    def lacking(name, *args, **kwargs):
        if name.split(".")[0] == "OCP":
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", lacking)
    with pytest.raises(WorkFailedError, match=r'pip install "driftform\[step\]"'):
        write(wavy_body)
    assert list(tmp_path.iterdir()) == []
