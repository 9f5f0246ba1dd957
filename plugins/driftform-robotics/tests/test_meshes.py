import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from driftform.agent import solid_of_revolution
from driftform_robotics.models.meshes import convex_pieces
from driftform_robotics.models.pipe import PLANKS, make_bore
from driftform_robotics.models.text import roll_pitch_yaw

profiles = st.lists(st.tuples(st.floats(0.0, 0.02), st.floats(0.002, 0.05)), min_size=2, max_size=12).filter(
    lambda steps: sum(step for step, _ in steps[1:]) > 1e-3
)


def contour_of(steps):
    x = np.concatenate(([0.0], np.cumsum([step for step, _ in steps[1:]])))
    r = [radius for _, radius in steps]
    return np.array([(x[0], 0.0), *zip(x, r, strict=True), (x[-1], 0.0)])


@given(profiles)
def test_pieces_are_convex_closed_and_together_the_hull(steps):
    contour = contour_of(steps)
    expected = solid_of_revolution(contour)
    pieces = convex_pieces(contour, segments=12)
    for piece in pieces:
        mesh = trimesh.Trimesh(piece.mesh.vertices, piece.mesh.triangles, process=False)
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(piece.volume, rel=1e-7)
        assert mesh.volume == pytest.approx(mesh.convex_hull.volume, rel=1e-6)
        # About its own centroid.
        assert abs(mesh.center_mass[0]) < 1e-8
    assert sum(p.volume for p in pieces) == pytest.approx(expected.volume, rel=1e-7)
    assert sum(p.volume * p.x for p in pieces) == pytest.approx(expected.first, abs=1e-7 * expected.volume)


def test_a_body_that_is_convex_or_folds_back_stays_in_one_piece():
    angle = np.linspace(np.pi, 0, 40)
    convex = np.column_stack((0.05 * np.cos(angle), 0.02 * np.sin(angle)))
    convex[[0, -1], 1] = 0
    folded = np.array([(0, 0), (0.0, 0.02), (0.03, 0.02), (0.02, 0.01), (0.05, 0.01), (0.05, 0)], dtype=float)
    for contour in (convex, folded):
        (piece,) = convex_pieces(contour)
        assert piece.volume == pytest.approx(solid_of_revolution(contour).volume)


def test_the_exported_hull_is_the_body_that_flies(job, export):
    mass = job.agent.mass
    moments = solid_of_revolution(job.agent.body.outer)
    for format in ("sdf", "uuv", "urdf", "mjcf"):
        mesh = trimesh.load_mesh(export(format, job) / "meshes/hull.obj")
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(moments.volume, rel=1e-6)
        np.testing.assert_allclose(mesh.center_mass, np.array([moments.centroid, 0, 0]) - mass.cog, atol=1e-7)


@pytest.mark.parametrize("end", [(9.0, 0.0, 0.0), (0.0, 0.0, 2.0), (1.0, -2.0, 0.5)])
def test_planks_are_the_wall_of_the_bore(end):
    """Their inner faces lie on the bore to within 0.1 % of its radius, next to one another, wherever it points."""
    start = (0.3, 0.1, -0.2)
    bore = make_bore(np.array(start), np.add(start, end), 0.5)
    axis = np.array(end) / np.linalg.norm(end)
    np.testing.assert_allclose(bore.rotation.T @ bore.rotation, np.eye(3), atol=1e-12)
    assert np.linalg.det(bore.rotation) == pytest.approx(1)
    np.testing.assert_allclose(bore.rotation[:, 0], axis, atol=1e-12)
    np.testing.assert_allclose(bore.position, np.array(start) + np.array(end) / 2)
    assert bore.length == pytest.approx(np.linalg.norm(end))
    planks = bore.make_planks()
    assert len(planks) == PLANKS
    for plank in planks:
        assert np.linalg.det(plank.rotation) == pytest.approx(1)
        for side in (-0.5, 0.5):
            inner = plank.position + plank.rotation @ (plank.size * (0.0, 0.0, -0.5))
            edge = plank.rotation @ np.array([0.0, side, 0.0]) * 2 * np.pi * 0.5 / PLANKS
            assert np.linalg.norm(inner + edge) == pytest.approx(0.5, rel=1e-3)
            assert np.linalg.norm(inner) == pytest.approx(0.5, rel=1e-3)
    assert {round(float(plank.size[0]), 9) for plank in planks} == {round(bore.length, 9)}


@given(st.floats(-3.1, 3.1), st.floats(-np.pi / 2, np.pi / 2), st.floats(-3.1, 3.1))
def test_angles_make_the_rotation_that_they_came_from(roll, pitch, yaw):
    def about(axis, angle):
        c, s = np.cos(angle), np.sin(angle)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        R = np.eye(3)
        R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
        return R

    def matrix(r, p, y):
        return about(2, y) @ about(1, p) @ about(0, r)

    R = matrix(roll, pitch, yaw)
    np.testing.assert_allclose(matrix(*roll_pitch_yaw(R)), R, atol=1e-7)


def test_every_mesh_of_every_format_has_one_normal_for_each_vertex(job, export):
    """DART crashes on a mesh without them."""
    for format in ("sdf", "uuv", "urdf", "mjcf"):
        paths = list(export(format, job).glob("meshes/*.obj"))
        assert len(paths) > 1
        for path in paths:
            lines = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
            points, normals = (np.array([line[1:] for line in lines if line[0] == key], float) for key in ("v", "vn"))
            assert normals.shape == points.shape
            assert np.linalg.norm(normals, axis=1) == pytest.approx(1, abs=1e-4)
            corners = [corner.split("/") for line in lines if line[0] == "f" for corner in line[1:]]
            assert all(vertex == normal for vertex, _, normal in corners)
