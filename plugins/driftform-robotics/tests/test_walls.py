"""The pipe with parts in the files of Gazebo and MuJoCo: a closed mesh that is displayed, and boxes that collide."""

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from robots import check_sdf

from driftform.interfaces import ExportJob
from driftform.water import Scenario
from driftform.water.fittings import fitting_array
from driftform.water.parts.grid_flow import wall_gaps
from driftform_robotics.models.pipe import list_bores, make_wall


def make_pipe() -> Scenario:
    parts = [
        {"length": 0.5},
        {"kind": "bend", "radius": 0.3, "roll_deg": 90},
        {"kind": "tee", "branch_radius": 0.05, "share": 0.3, "branch": [{"length": 0.3, "outlet": "up"}]},
        {"kind": "reducer", "length": 0.2, "radius": 0.05},
        {"length": 0.3, "outlet": "on"},
    ]
    return Scenario.model_validate(
        {"pipe": {"radius": 0.1, "parts": parts}, "flow": {"speed": 0.5}, "release": {"position": [0.1, 0, 0]}}
    )


@pytest.fixture(scope="module")
def bent(jobs: dict[str, ExportJob]) -> ExportJob:
    return replace(jobs["random"], scenario=make_pipe())


def test_the_mesh_is_closed_and_faces_outward(bent: ExportJob) -> None:
    mesh = make_wall(bent.scenario.pipe)
    edges = Counter((int(a), int(b)) for i, j in ((0, 1), (1, 2), (2, 0)) for a, b in mesh.triangles[:, [i, j]])
    assert all(count == 1 and edges[b, a] == 1 for (a, b), count in list(edges.items()))
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    volumes = sum(plank.size.prod() for bore in list_bores(bent.scenario.pipe) for plank in bore.make_planks())
    assert (a * np.cross(b, c)).sum() / 6 == pytest.approx(volumes, rel=1e-9)


@pytest.mark.parametrize("gazebo", ["harmonic", "fortress"])
def test_gazebo_displays_the_mesh_and_lets_bodies_collide_with_boxes(
    gazebo: str, bent: ExportJob, export: Callable
) -> None:
    folder = export("sdf", bent, gazebo=gazebo)
    wall = ET.parse(folder / "world.sdf").getroot().find(".//model[@name='pipe']/link")
    [visual] = wall.findall("visual")
    assert (folder / visual.findtext("geometry/mesh/uri")).is_file()
    assert len(wall.findall("collision")) > 500
    assert all(c.find("geometry/box") is not None for c in wall.findall("collision"))


def test_there_is_no_world_in_the_frame_of_water_that_turns(bent: ExportJob, export: Callable) -> None:
    folder = export("sdf", bent)
    text = (folder / "world.sdf").read_text(encoding="utf-8")
    assert not (folder / "drift.sdf").exists()
    assert "drift.sdf" not in text
    assert "does not turn with the pipe" in text


def test_ignition_accepts_a_world_with_parts(
    bent: ExportJob, export: Callable, requires_program: Callable[[str], str]
) -> None:
    done = check_sdf(requires_program("ign"), export("sdf", bent, gazebo="fortress") / "world.sdf")
    assert "Error" not in done.stderr and "Warning" not in done.stderr, done.stderr
    assert "Valid." in done.stdout


def read_scene(folder: Path) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return model, data


def test_mujoco_displays_the_mesh_where_the_pipe_is(bent: ExportJob, export: Callable) -> None:
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


def test_in_mujoco_the_water_touches_nothing_and_a_body_cannot_leave_through_the_wall(
    bent: ExportJob, export: Callable
) -> None:
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
