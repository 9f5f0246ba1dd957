"""Files of random agents, sealed and as kits, read back by other libraries: what they hold is what was simulated."""

import json
import re
import subprocess
import zipfile
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh
from manifold3d import Error, Manifold, Mesh64

from driftform.interfaces import ExportJob
from driftform.study import load_study
from driftform_frusta.csg import Revolve, Translate
from driftform_frusta.exporters.meshes import GlbExporter, ObjExporter, PlyExporter, StlExporter
from driftform_frusta.exporters.scad import ScadExporter
from driftform_frusta.exporters.threemf import ThreeMfExporter
from driftform_frusta.hull import hull_volume
from driftform_frusta.parts import Part, make_parts
from driftform_frusta.solid import to_solid
from driftform_frusta.triangles import Mesh

MESHES = (StlExporter, ThreeMfExporter, GlbExporter, ObjExporter, PlyExporter)
ATTACHED = "https://driftform.invalid/2026/attachment"

# From what a file holds to mm with z up.
UPRIGHT = 1e3 * np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])


def jobs(occupied, count):
    pipeline = load_study("paper", settings=[f"grammar.occupied={occupied}"], run={"seed": 0}).make_pipeline()
    rng = np.random.default_rng(6)
    agents = [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(count)]
    document = {"format": "driftform-agent", "name": "<a> & b"}
    return [ExportJob(f"agent {i}", agent, pipeline.scenario, document) for i, agent in enumerate(agents)]


def export(exporter, job, folder, **options):
    """The files that hold solids; the assembly sheet of a kit has tests of its own."""
    made = exporter(exporter.Options(**options))
    written = made.write(job, folder / f"agent{made.suffix}")
    return [file for file in written if "-assembly-" not in file.path]


def read_3mf(path):
    """Objects of a 3MF file as name, vertices and triangles in build order, read by lib3mf in its strict mode."""
    import lib3mf

    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.AddRelationToRead(ATTACHED)
    reader.ReadFromFile(str(path))
    assert [reader.GetWarning(i) for i in range(reader.GetWarningCount())] == []
    found, items = [], model.GetBuildItems()
    while items.MoveNext():
        item = items.GetCurrent()
        mesh = model.GetMeshObjectByID(item.GetObjectResourceID())
        assert mesh.IsManifoldAndOriented()
        vertices = np.array([list(v.Coordinates) for v in mesh.GetVertices()])
        triangles = np.array([list(t.Indices) for t in mesh.GetTriangleIndices()])
        transform = np.array([list(row) for row in item.GetObjectTransform().Fields])
        found.append((mesh.GetName(), vertices @ transform[:3] + transform[3], triangles))
    return found


def reload(files):
    """Every part that files hold: name, vertices in mm with z up, triangles; nothing mended on the way."""
    parts = []
    for file in files:
        if file.format == "3mf":
            parts += read_3mf(file.path)
            continue
        # STL holds loose triangles, which are joined by their coordinates; the others share their vertices.
        options = {"split_objects": True} if file.format == "obj" else {"maintain_order": True}
        scene = trimesh.load_scene(file.path, process=file.format == "stl", validate=False, **options)
        for node in scene.graph.nodes_geometry:
            transform, name = scene.graph[node]
            mesh = scene.geometry[name]
            assert np.allclose(transform, np.eye(4))
            points = mesh.vertices @ UPRIGHT.T if file.format == "glb" else mesh.vertices
            # Of a file with several parts, a reader may give all vertices to each.
            used, corners = np.unique(mesh.faces, return_inverse=True)
            parts.append((node, np.array(points[used], dtype=float), corners.reshape(-1, 3)))
    return parts


def assert_sound(vertices, triangles, shells, volume):
    """A closed solid by manifold3d, with this many surfaces of which one is the outside, and of this volume."""
    solid = Manifold(Mesh64(np.ascontiguousarray(vertices), triangles.astype(np.uint64)))
    assert solid.status() == Error.NoError
    signs = [np.sign(shell.volume()) for shell in solid.decompose()]
    assert sorted(signs) == [-1] * (shells - 1) + [1]
    # manifold3d may turn what is inside out; the plain sum of tetrahedra does not.
    assert Mesh(vertices, triangles).volume == pytest.approx(volume, rel=1e-4)
    assert solid.volume() == pytest.approx(volume, rel=1e-4)


def check_all_formats(job, folder, **options):
    body = job.agent.body
    parts = make_parts(body, StlExporter.Options(**options))
    for exporter in MESHES:
        files = export(exporter, job, folder, **options)
        found = reload(files)
        assert len(found) == len(parts), exporter.name
        # Sorted by volume, as not every reader keeps names.
        found.sort(key=lambda part: Mesh(*part[1:]).volume)
        for (_, vertices, triangles), part in zip(found, sorted(parts, key=lambda p: p.solid.volume), strict=True):
            assert_sound(vertices, triangles, len(part.solid.shells), part.solid.volume)
        if len(parts) == 1:
            assert Mesh(*found[0][1:]).volume == pytest.approx(1e9 * hull_volume(body), rel=1e-4)


@pytest.mark.peers
@pytest.mark.parametrize("occupied", ["insert", "skip"])
@pytest.mark.parametrize("kit", [False, True], ids=["sealed", "kit"])
def test_every_mesh_format_holds_the_solids_that_were_simulated(occupied, kit, tmp_path):
    for job in jobs(occupied, 2):
        check_all_formats(job, tmp_path, kit=kit)


@pytest.fixture(scope="module")
def kit():
    """An agent that makes a kit of two parts or more."""
    return jobs("insert", 1)[0]


@pytest.mark.parametrize("exporter", [StlExporter, PlyExporter])
def test_a_format_for_one_solid_has_a_file_for_each_part_that_stands_on_the_bed(exporter, kit, tmp_path):
    files = export(exporter, kit, tmp_path, kit=True)
    names = [part.name for part in make_parts(kit.agent.body, StlExporter.Options(kit=True))]
    assert [Path(f.path).name for f in files] == [f"agent-{name.replace(' ', '-')}{exporter.suffix}" for name in names]
    for _, vertices, _ in reload(files):
        assert vertices[:, 2].min() == 0
        assert np.abs(vertices[:, :2].min(axis=0) + vertices[:, :2].max(axis=0)).max() < 1e-3


@pytest.mark.parametrize("exporter", [GlbExporter, ObjExporter])
def test_parts_are_named_and_lie_as_they_are_joined_in_a_scene(exporter, kit, tmp_path):
    [file] = export(exporter, kit, tmp_path, kit=True)
    parts = make_parts(kit.agent.body, StlExporter.Options(kit=True))
    found = {name.replace("_", " "): vertices for name, vertices, _ in reload([file])}
    assert sorted(found) == sorted(part.name for part in parts)
    for part in parts:
        box = np.concatenate([found[part.name].min(axis=0), found[part.name].max(axis=0)])
        assert np.allclose(box, part.solid.bounds.ravel(), atol=1e-4)
    whole = np.concatenate(list(found.values()))
    assert np.ptp(whole[:, 2]) == pytest.approx(1000 * kit.agent.body.length, abs=1e-3)


def test_a_glb_file_is_in_metres_with_y_up_and_a_colour_for_each_part(kit, tmp_path):
    [file] = export(GlbExporter, kit, tmp_path, kit=True)
    data = Path(file.path).read_bytes()
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    heights = [document["accessors"][m["primitives"][0]["attributes"]["POSITION"]] for m in document["meshes"]]
    assert min(a["min"][1] for a in heights) == pytest.approx(0, abs=1e-9)
    assert max(a["max"][1] for a in heights) == pytest.approx(kit.agent.body.length, rel=1e-6)
    colours = [m["pbrMetallicRoughness"]["baseColorFactor"] for m in document["materials"]]
    assert len({tuple(colour) for colour in colours}) == len(document["nodes"]) >= 2


@pytest.mark.peers
def test_a_3mf_plate_stands_on_the_bed_with_its_parts_apart(kit, tmp_path):
    options = {"kit": True, "bed": (0.2, 0.15, 0.21)}
    [file] = export(ThreeMfExporter, kit, tmp_path, **options)
    assert file.facts["fits_bed"] is True
    boxes = [(v.min(axis=0), v.max(axis=0)) for _, v, _ in read_3mf(file.path)]
    low, high = np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)
    assert all(b[0][2] == 0 for b in boxes)
    assert (low[:2] >= 0).all() and (high[:2] <= (200, 150)).all()
    assert (low[:2] + high[:2]) / 2 == pytest.approx((100, 75), abs=0.01)
    for (low_a, high_a), (low_b, high_b) in pairwise(sorted(boxes, key=lambda b: tuple(b[0]))):
        apart = np.maximum(low_a[:2] - high_b[:2], low_b[:2] - high_a[:2]).max()
        assert apart >= 4.99


def test_parts_beside_their_axis_lie_in_the_middle_of_their_places():
    lug = Translate((40.0, 7.0, 0.0), Revolve(((0, 0), (5, 0), (5, 10), (0, 10))))
    exporter = ThreeMfExporter(ThreeMfExporter.Options())
    spots = exporter.place_parts([Part(name, lug, to_solid(lug)) for name in ("one", "two")])
    middles = np.array([np.add(spot.mesh.bounds[:, :2].mean(axis=0), (spot.x, spot.y)) for spot in spots])
    # About the middle of the plate, and apart.
    assert middles.sum(axis=0) == pytest.approx((0, 0), abs=1e-6)
    assert np.linalg.norm(middles[1] - middles[0]) > 10


@pytest.mark.peers
def test_what_does_not_fit_on_one_plate_goes_into_several_files(kit, tmp_path):
    files = export(ThreeMfExporter, kit, tmp_path, kit=True, bed=(0.05, 0.04, 0.25))
    assert [Path(f.path).name for f in files] == [f"agent-plate-{i + 1}.3mf" for i in range(len(files))]
    assert len(files) == len(make_parts(kit.agent.body, StlExporter.Options(kit=True))) >= 2
    assert all(len(read_3mf(f.path)) == 1 for f in files)


@pytest.mark.peers
def test_a_part_that_is_too_tall_for_the_bed_is_written_and_told_of(kit, tmp_path):
    [file] = export(ThreeMfExporter, kit, tmp_path, bed=(0.25, 0.21, 0.02))
    assert file.facts["fits_bed"] is False
    assert len(read_3mf(file.path)) == 1


@pytest.mark.peers
def test_a_3mf_package_carries_its_agent_its_source_its_picture_and_hints(kit, tmp_path):
    import lib3mf

    [file] = export(ThreeMfExporter, kit, tmp_path, layer_height=0.00015, infill=0.15)
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.AddRelationToRead(ATTACHED)
    reader.ReadFromFile(file.path)
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    attached = {}
    for i in range(model.GetAttachmentCount()):
        attachment = model.GetAttachment(i)
        attached[attachment.GetPath()] = bytes(attachment.WriteToBuffer())
    assert json.loads(attached["/Metadata/agent.json"]) == kit.document
    [scad] = export(ScadExporter, kit, tmp_path)
    assert attached["/Metadata/agent.scad"] == Path(scad.path).read_bytes()
    picture = bytes(model.GetPackageThumbnailAttachment().WriteToBuffer())
    assert picture.startswith(b"\x89PNG\r\n\x1a\n")
    group = model.GetMetaDataGroup()
    told = {}
    for i in range(group.GetMetaDataCount()):
        entry = group.GetMetaData(i)
        told[entry.GetName()] = entry.GetValue()
    assert told["Title"] == kit.name
    assert f"{1e3 * file.facts['mass_kg']:.2f} g" in told["Description"]


def test_each_part_of_a_3mf_package_has_a_material_with_its_name_and_colour(kit, tmp_path):
    [file] = export(ThreeMfExporter, kit, tmp_path, kit=True)
    with zipfile.ZipFile(file.path) as archive:
        assert archive.testzip() is None
        text = archive.read("3D/3dmodel.model").decode()
    materials = re.findall(r'<base name="([^"]+)" displaycolor="(#[0-9A-F]{8})"/>', text)
    objects = re.findall(r'<object id="\d+" type="model" name="([^"]+)" pid="1" pindex="(\d+)">', text)
    assert [materials[int(index)][0] for _, index in objects] == [name for name, _ in objects]
    assert len({colour for _, colour in materials}) == len(materials) >= 2


def test_prusa_slicer_opens_a_plate_as_the_right_parts(kit, tmp_path, requires_program):
    slicer = requires_program("prusa-slicer")
    [file] = export(ThreeMfExporter, kit, tmp_path, kit=True)
    found = info(slicer, file.path)
    parts = make_parts(kit.agent.body, StlExporter.Options(kit=True))
    assert len(found) == len(parts)
    for told, part in zip(found, parts, strict=True):
        assert told["manifold"] == "yes"
        assert int(told["number_of_parts"]) == len(part.solid.shells)
        assert float(told["volume"]) == pytest.approx(part.solid.volume, rel=1e-4)
        assert not {key for key in told if key.endswith(("_reversed", "_fixed", "_removed", "_added"))}


def info(slicer, path):
    """What PrusaSlicer tells of each object of a file."""
    done = subprocess.run(
        [slicer, "--info", path], capture_output=True, encoding="utf-8", errors="replace", timeout=600, check=True
    )
    found = []
    for line in done.stdout.splitlines():
        if line.startswith("["):
            continue
        key, _, value = line.partition(" = ")
        if key == "size_x":
            found.append({})
        if found and value:
            found[-1][key.strip()] = value.strip()
    return found
