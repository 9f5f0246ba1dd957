"""The wall of a pipe with parts, for Gazebo and MuJoCo: a closed mesh that is displayed, and boxes that collide.

No box reaches into the water, and none of a sphere's ways through the wall is open.
"""

import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from robots import check_sdf

from driftform.water import Scenario
from driftform.water.fittings import fitting_array
from driftform.water.parts.grid_flow import wall_gaps
from driftform_robotics.models.pipe import list_bores, make_wall


@pytest.fixture(scope="module")
def bent(jobs):
    parts = [
        {"length": 0.5},
        {"kind": "bend", "radius": 0.3, "roll_deg": 90},
        {"kind": "tee", "branch_radius": 0.05, "share": 0.3, "branch": [{"length": 0.3, "outlet": "up"}]},
        {"kind": "reducer", "length": 0.2, "radius": 0.07},
        {"length": 0.3, "outlet": "on"},
    ]
    tables = {"pipe": {"radius": 0.1, "parts": parts}, "flow": {"speed": 0.5}, "release": {"position": [0.1, 0, 0]}}
    return replace(jobs["random"], scenario=Scenario.model_validate(tables))


@pytest.fixture(scope="module")
def boxes(bent):
    """The pipe; and position, axes (columns) and half size of every box of its wall, in the world frame."""
    pipe = bent.scenario.pipe
    found = [
        (b.position + b.rotation @ p.position, b.rotation @ p.rotation, p.size / 2)
        for b in list_bores(pipe)
        for p in b.make_planks()
    ]
    return pipe, [np.array(values) for values in zip(*found, strict=True)]


def covers(boxes, point, margin=0.0):
    position, axes, half = boxes
    local = np.einsum("kji,kj->ki", axes, point - position)
    return bool((np.abs(local) <= half + margin).all(axis=1).any())


def test_the_water_along_the_axes_is_free(boxes):
    pipe, found = boxes
    for placed in pipe.layout.parts:
        for axis in placed.part.list_axes(0.02):
            for point, radius in zip(axis.points, axis.radii, strict=True):
                assert not covers(found, point, margin=0.5 * radius)


def test_the_wall_is_closed_except_where_the_branch_leaves(boxes):
    pipe, found = boxes
    rng = np.random.default_rng(0)
    for placed in pipe.layout.parts:
        if placed.part.list_exits()[0].radius == 0.05 or len(placed.part.list_exits()) > 1:
            continue
        axis = placed.part.list_axes(0.01)[0]
        for k in rng.integers(1, len(axis.points) - 1, size=20):
            along = axis.points[k + 1] - axis.points[k - 1]
            across = np.cross(along, rng.standard_normal(3))
            across /= np.linalg.norm(across)
            ray = axis.points[k] + axis.radii[k] * np.linspace(0.95, 1.08, 40)[:, None] * across
            assert any(covers(found, point) for point in ray)


def test_the_wall_of_the_run_is_open_into_the_branch(boxes):
    pipe, found = boxes
    [tee] = [placed.part for placed in pipe.layout.parts if len(placed.part.list_exits()) > 1]
    for height in np.linspace(0.0, tee.legs[2], 30):
        assert not covers(found, tee.origin + height * tee.branch_axes[0])


def test_the_mesh_is_closed_and_faces_outward(bent):
    mesh = make_wall(bent.scenario.pipe)
    edges = Counter((int(a), int(b)) for i, j in ((0, 1), (1, 2), (2, 0)) for a, b in mesh.triangles[:, [i, j]])
    assert all(count == 1 and edges[b, a] == 1 for (a, b), count in list(edges.items()))
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    volumes = sum(plank.size.prod() for bore in list_bores(bent.scenario.pipe) for plank in bore.make_planks())
    assert (a * np.cross(b, c)).sum() / 6 == pytest.approx(volumes, rel=1e-9)


@pytest.mark.parametrize("gazebo", ["harmonic", "fortress"])
def test_gazebo_displays_the_mesh_and_lets_bodies_collide_with_boxes(gazebo, bent, export):
    folder = export("sdf", bent, gazebo=gazebo)
    wall = ET.parse(folder / "world.sdf").getroot().find(".//model[@name='pipe']/link")
    [visual] = wall.findall("visual")
    assert (folder / visual.findtext("geometry/mesh/uri")).is_file()
    assert len(wall.findall("collision")) > 500
    assert all(c.find("geometry/box") is not None for c in wall.findall("collision"))


def test_there_is_no_world_in_the_frame_of_water_that_turns(bent, export):
    folder = export("sdf", bent)
    text = (folder / "world.sdf").read_text(encoding="utf-8")
    assert not (folder / "drift.sdf").exists()
    assert "drift.sdf" not in text
    assert "does not turn with the pipe" in text


def test_ignition_accepts_a_world_with_parts(bent, export, requires_program):
    done = check_sdf(requires_program("ign"), export("sdf", bent, gazebo="fortress") / "world.sdf")
    assert "Error" not in done.stderr and "Warning" not in done.stderr, done.stderr
    assert "Valid." in done.stdout


def read_scene(folder):
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return model, data


def test_mujoco_displays_the_mesh_where_the_pipe_is(bent, export):
    """MuJoCo moves the corners of a mesh to its own centre and axes, and the geom back."""
    model, data = read_scene(export("mjcf", bent))
    mujoco.mj_forward(model, data)
    geom = model.geom("wall")
    assert not geom.contype[0] and not geom.conaffinity[0]
    mesh = model.mesh(geom.dataid[0])
    first, count = int(mesh.vertadr[0]), int(mesh.vertnum[0])
    seen = data.geom_xpos[geom.id] + model.mesh_vert[first : first + count] @ data.geom_xmat[geom.id].reshape(3, 3).T
    wall = make_wall(bent.scenario.pipe).vertices
    np.testing.assert_allclose(seen.min(axis=0), wall.min(axis=0), atol=1e-5)
    np.testing.assert_allclose(seen.max(axis=0), wall.max(axis=0), atol=1e-5)


def test_in_mujoco_the_water_touches_nothing_and_a_body_cannot_leave_through_the_wall(bent, export):
    model, data = read_scene(export("mjcf", bent))
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    # Straight on, where the bend turns to the right.
    data.qvel[:3] = (2.0, 0.0, 0.0)
    model.opt.wind[:] = 0.0
    touched = 0
    while data.time < 1.0:
        mujoco.mj_step(model, data)
        touched += data.ncon
    assert touched
    gaps = wall_gaps(np.array([data.site("core").xpos]), fitting_array(bent.scenario))[0]
    assert gaps[0] > 0
