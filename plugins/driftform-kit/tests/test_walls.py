"""The thinnest wall of solids whose walls are known."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform_frusta.triangles import Mesh
from driftform_kit.checks.walls import REACH, find_thinnest_wall


def wall_of(mesh):
    found = find_thinnest_wall(Mesh(mesh.vertices, mesh.faces))
    return found and found[0]


def shell_of(outer, inner):
    inner = inner.copy()
    inner.invert()
    return trimesh.util.concatenate([outer, inner])


@given(thickness=st.floats(0.1, 4.0), radius=st.floats(6.0, 100.0))
@settings(max_examples=15, deadline=None)
def test_a_sealed_sphere(thickness, radius):
    outer = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    inner = trimesh.creation.icosphere(subdivisions=3, radius=radius - thickness)
    # Both are the same facets at two scales, whose planes are nearer than the spheres by their apothem.
    apothem = np.einsum("ij,ij->i", outer.triangles_center, outer.face_normals).min() / radius
    assert wall_of(shell_of(outer, inner)) == pytest.approx(apothem * thickness, rel=0.02)


@given(thickness=st.floats(0.1, 4.0))
@settings(max_examples=10, deadline=None)
def test_an_open_tube(thickness):
    # Like one half of a kit: open at one end, so that one surface goes from outside to inside.
    tube = trimesh.creation.annulus(r_min=12 - thickness, r_max=12, height=30, sections=64)
    assert wall_of(tube) == pytest.approx(thickness, rel=0.02)


def test_a_wall_that_tapers_is_as_thin_as_its_thin_end():
    # A cone within a cylinder: the wall goes from 3 mm to 0.4 mm, along triangles as long as the part.
    meridian = np.array([[0, 0], [10, 0], [10, 40], [9.6, 40], [7, 2], [0, 2]], dtype=float)
    cup = trimesh.creation.revolve(meridian, sections=64)
    assert cup.is_watertight
    assert wall_of(cup) == pytest.approx(0.4, rel=0.15)


def test_the_place_is_told():
    box, hollow = trimesh.creation.box((20, 20, 20)), trimesh.creation.box((16, 16, 16))
    hollow.apply_translation((1.5, 0, 0))
    shell = shell_of(box, hollow)
    found = find_thinnest_wall(Mesh(shell.vertices, shell.faces))
    assert found[0] == pytest.approx(0.5, rel=1e-6)
    assert 9.5 - 1e-6 <= found[1][0] <= 10 + 1e-6


@pytest.mark.parametrize("angle_deg", [40, 60, 90, 120])
def test_sharp_edges_are_no_walls(angle_deg):
    # A wedge is thin at its edge, however thick it is elsewhere.
    half = np.radians(angle_deg / 2)
    long = 40.0
    wedge = trimesh.creation.extrude_triangulation(
        np.array([[0, 0], [long * np.cos(half), -long * np.sin(half)], [long * np.cos(half), long * np.sin(half)]]),
        np.array([[0, 1, 2]]),
        height=20,
    )
    assert wedge.is_watertight
    assert wall_of(wedge) is None


def test_a_thick_solid_has_no_thin_wall():
    assert wall_of(trimesh.creation.box((2 * REACH,) * 3)) is None
