"""Every format gives the same parts, in mm and z up; what cannot be read is an error of one line."""

import json
import shutil
import sys

import numpy as np
import pytest
import trimesh
from prints import CORNERS, TRIANGLES, mesh_xml, write_3mf

from driftform.errors import InputError, WorkFailedError
from driftform.interfaces import PrintJob, Table
from driftform.types import State
from driftform.util import foreign
from driftform_kit.checks.admesh import AdmeshChecker
from driftform_kit.reading import provide_stl, read_meshes


@pytest.fixture(scope="module", autouse=True)
def in_this_process():
    """Read in this process: one for each file takes a third of a second. tests/util/test_hostile_files.py has these."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(foreign, "call_apart", lambda function, path: function(str(path)))
        yield


BLOCK = trimesh.Trimesh(CORNERS, TRIANGLES, process=False)


def same(part, offset=(0, 0, 0)):
    found = {tuple(np.round(v, 4)) for v in part.vertices}
    volume = part.volume
    return found == {tuple(np.round(v + offset, 4)) for v in BLOCK.vertices} and np.isclose(volume, BLOCK.volume)


@pytest.mark.parametrize("name", ["block.stl", "text.stl", "block.obj", "block.ply", "BLOCK.STL"])
def test_formats_without_a_unit_are_in_millimetres(tmp_path, name):
    path = tmp_path / name
    kind = "stl_ascii" if name == "text.stl" else path.suffix[1:].lower()
    BLOCK.export(path, file_type=kind)
    [part] = read_meshes(path)
    assert part.name == path.stem
    assert same(part)


def test_glb_is_in_metres_with_y_up(tmp_path):
    # What points up here points along y there, and what comes towards the viewer there is -y here.
    x, y, z = 0.001 * BLOCK.vertices.T
    trimesh.Trimesh(np.column_stack((x, z, -y)), BLOCK.faces, process=False).export(tmp_path / "block.glb")
    [part] = read_meshes(tmp_path / "block.glb")
    assert same(part)


def test_a_scene_s_parts_are_where_their_nodes_put_them(tmp_path):
    scene = trimesh.Scene()
    for number, shift in enumerate((0.0, 0.05)):
        place = trimesh.transformations.translation_matrix((shift, 0, 0))
        scene.add_geometry(trimesh.creation.box((0.01,) * 3), geom_name=f"part {number}", transform=place)
    scene.export(tmp_path / "two.glb")
    parts = read_meshes(tmp_path / "two.glb")
    assert sorted(part.name for part in parts) == ["part 0", "part 1"]
    assert sorted(round(float(part.bounds[0, 0]), 3) for part in parts) == [-5, 45]


def test_3mf_places_each_item_of_the_build(tmp_path):
    resources = f'<object id="1" name="fore shell">{mesh_xml()}</object><object id="2">{mesh_xml()}</object>'
    build = '<item objectid="1" transform="1 0 0 0 1 0 0 0 1 40 50 0"/><item objectid="2" partnumber="aft"/>'
    fore, aft = read_meshes(write_3mf(tmp_path / "two.3mf", resources, build))
    assert (fore.name, aft.name) == ("fore shell", "aft")
    assert same(fore, (40, 50, 0)) and same(aft)


def test_an_object_that_is_not_built_is_no_part(tmp_path):
    resources = f'<object id="1">{mesh_xml()}</object><object id="2">{mesh_xml()}</object>'
    assert len(read_meshes(write_3mf(tmp_path / "one.3mf", resources, '<item objectid="2"/>'))) == 1


@pytest.mark.parametrize(
    ("unit", "millimetres"),
    [("micron", 1e-3), ("millimeter", 1), ("centimeter", 10), ("inch", 25.4), ("foot", 304.8), ("meter", 1e3)],
)
def test_3mf_tells_its_unit(tmp_path, unit, millimetres):
    resources = f'<object id="1">{mesh_xml(CORNERS / millimetres)}</object>'
    [part] = read_meshes(write_3mf(tmp_path / "block.3mf", resources, unit=unit))
    assert same(part)


def test_components_are_placed_within_their_object(tmp_path):
    # First mirrored in x and moved up by 5, then turned by a right angle about z and moved along x.
    resources = f"""<object id="1">{mesh_xml()}</object><object id="2" name="whole"><components>
        <component objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 5"/></components></object>"""
    build = '<item objectid="2" transform="0 1 0 -1 0 0 0 0 1 100 0 0"/>'
    [part] = read_meshes(write_3mf(tmp_path / "whole.3mf", resources, build))
    x, y, z = BLOCK.vertices.T
    assert {tuple(v) for v in part.vertices} == {tuple(v) for v in np.column_stack((100 - y, -x, z + 5))}
    # A mirror does not turn a part inside out.
    assert part.volume == pytest.approx(BLOCK.volume)


@pytest.mark.parametrize(
    ("resources", "build", "message"),
    [
        ("", '<item objectid="7"/>', "object 7, which is missing"),
        ("", "", "has no triangle"),
        ('<object id="1"/>', "<item/>", "lacks 'objectid'"),
        ('<object id="1"/>', '<item objectid="1" transform="1 0 0"/>', "3 numbers"),
        (
            '<object id="1"><components><component objectid="1"/></components></object>',
            '<item objectid="1"/>',
            "within components",
        ),
        (
            '<object id="1"><mesh><triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh></object>',
            '<item objectid="1"/>',
            "missing vertices",
        ),
        ("<object", "", "not XML"),
    ],
)
def test_a_3mf_that_is_wrong_is_one_line(tmp_path, resources, build, message):
    path = write_3mf(tmp_path / "wrong.3mf", resources, build)
    with pytest.raises(InputError, match=message) as caught:
        read_meshes(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".glb", ".3mf"])
@pytest.mark.parametrize("content", [b"", b"\x00\xff\x80" * 99, b'{"a": 1}\n', b"solid x\nvertex a b c\n"])
def test_what_is_no_such_file_is_one_line(tmp_path, suffix, content):
    path = tmp_path / f"wrong{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError, match="wrong") as caught:
        read_meshes(path)
    assert "\n" not in str(caught.value)


def test_an_unknown_suffix_names_those_that_are_known(tmp_path):
    path = tmp_path / "hull.step"
    path.write_text("ISO-10303-21;")
    with pytest.raises(InputError, match=r"\.3mf.*\.stl"):
        read_meshes(path)


def test_a_file_that_changes_is_read_anew(tmp_path):
    path = tmp_path / "block.stl"
    BLOCK.export(path)
    assert len(read_meshes(path)[0].triangles) == 4
    trimesh.creation.box((5, 5, 5)).export(path)
    assert len(read_meshes(path)[0].triangles) == 12


def test_names_from_files_cannot_steer_a_terminal(tmp_path):
    name = json.dumps("evil\x9b2J" + 100 * "x")[1:-1].replace("\\u009b", "&#155;")
    resources = f'<object id="1" name="{name}">{mesh_xml()}</object>'
    [part] = read_meshes(write_3mf(tmp_path / "evil.3mf", resources))
    assert part.name.isprintable() and len(part.name) <= 40 and part.name.startswith("evil")


def test_openscad_source_is_rendered(tmp_path, requires_program):
    requires_program("openscad")
    path = tmp_path / "cube.scad"
    path.write_text("translate([1, 2, 3]) cube([10, 20, 30]);")
    [part] = read_meshes(path)
    assert part.name == "cube" and np.ptp(part.bounds, axis=0) == pytest.approx([10, 20, 30])
    assert part.bounds[0] == pytest.approx([1, 2, 3])
    for source, told in (
        ("cube([10, 20);", "ERROR"),
        ("cylinder(h=nonsense());", "WARNING"),
        ("// none", "none|no solid"),
    ):
        path.write_text(source)
        with pytest.raises(InputError, match=f"(?i)OpenSCAD: .*({told}|empty|object)"):
            read_meshes(path)


def test_openscad_source_without_openscad(tmp_path, monkeypatch):
    path = tmp_path / "cube.scad"
    path.write_text("cube(10);")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert shutil.which("openscad") is None
    with pytest.raises(WorkFailedError, match="openscad is not on PATH"):
        read_meshes(path)


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
@pytest.mark.parametrize("left", [0.3, 0.6, 0.97])
def test_a_truncated_stl_is_named_as_such(tmp_path, kind, left):
    path = tmp_path / "cut.stl"
    BLOCK.export(path, file_type=kind)
    content = path.read_bytes()
    path.write_bytes(content[: int(left * len(content))])
    with pytest.raises(InputError, match=r"cut\.stl: .* truncated") as caught:
        read_meshes(path)
    assert "\n" not in str(caught.value)


def test_an_stl_of_more_bytes_than_its_triangles_is_none(tmp_path):
    BLOCK.export(tmp_path / "long.stl")
    with (tmp_path / "long.stl").open("ab") as file:
        file.write(b"more")
    with pytest.raises(InputError, match=r"no STL file: it states 4 triangles, and has 4\.08"):
        read_meshes(tmp_path / "long.stl")


def test_a_truncated_3mf_is_named_as_such(tmp_path):
    path = write_3mf(tmp_path / "cut.3mf")
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(InputError, match=r"cut\.3mf: .* truncated"):
        read_meshes(path)


def test_admesh_is_understood_whatever_bytes_it_prints(sound, tmp_path, monkeypatch):
    names = ("Total disconnected facets", "Degenerate facets", "Facets reversed", "Facets added", "Edges fixed")
    report = b"Header : \xd0\xff\x80\n" + "".join(f"{name} : 0\n" for name in names).encode()
    program = tmp_path / "admesh"
    program.write_text(f"#!{sys.executable}\nimport sys\nsys.stdout.buffer.write({report!r})\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    checker = AdmeshChecker(Table())
    [finding] = checker.check(PrintJob((sound,)))
    assert finding.state is State.PASS


def test_the_header_of_a_copied_part_ends_with_a_nul(sound, tmp_path):
    trimesh.load_mesh(sound).export(tmp_path / "hull.ply")
    [copy] = provide_stl([tmp_path / "hull.ply"], tmp_path)
    data = copy.read_bytes()
    assert not data.startswith(b"solid")
    assert data[79] == 0
    assert [len(part.triangles) for part in read_meshes(copy)] == [len(part.triangles) for part in read_meshes(sound)]
