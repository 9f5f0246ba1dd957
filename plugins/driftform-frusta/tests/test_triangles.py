"""Meshes of triangles against closed forms, and their files against the formats."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.agent import solid_of_revolution
from driftform_frusta.triangles import Mesh, area_factor


def box_mesh():
    """A box of 1 x 2 x 3 with a corner at the origin."""
    vertices = np.array(list(itertools.product((0, 1), (0, 2), (0, 3))), dtype=np.float32)
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Mesh(vertices, np.array([half for a, b, c, d in squares for half in ((a, b, c), (a, c, d))]))


@pytest.mark.parametrize("segments", [3, 4, 7, 64])
def test_the_area_factor_gives_a_polygon_the_area_of_its_circle(segments):
    angle = 2 * np.pi * np.arange(segments) / segments
    x, y = 2 * area_factor(segments) * np.array([np.cos(angle), np.sin(angle)])
    assert (x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2 == pytest.approx(4 * np.pi, rel=1e-12)


@given(st.lists(st.tuples(st.floats(0.1, 5), st.floats(0.1, 3)), min_size=1, max_size=8), st.integers(3, 20))
def test_a_revolved_line_has_the_volume_and_the_centroid_of_the_closed_form(steps, segments):
    z = np.cumsum([0.0, *(step for step, _ in steps)])
    r = [radius for _, radius in steps]
    line = np.array([(0, z[0]), *zip([*r, r[-1]], z, strict=True), (0, z[-1])])
    mesh = Mesh.revolve(line, segments)
    vertices, triangles = mesh.vertices, mesh.triangles
    expected = solid_of_revolution(line[:, ::-1])
    assert mesh.is_closed
    assert len(np.unique(triangles)) == len(vertices) == segments * len(z) + 2
    assert mesh.volume == pytest.approx(expected.volume, rel=1e-10)
    # The centroid, by the divergence theorem: half the integral of z^2 over the surface's projection along z.
    a, b, c = vertices[triangles, 2].T
    square = (a * a + b * b + c * c + a * b + b * c + c * a) / 6
    first = (square * mesh.area_vectors[:, 2]).sum() / 2
    assert first == pytest.approx(expected.first, rel=1e-9)


def test_area_vectors_point_outward_and_close():
    box = box_mesh()
    vectors = box.area_vectors
    assert vectors.shape == (12, 3)
    assert np.allclose(vectors.sum(axis=0), 0)
    assert sorted(np.linalg.norm(vectors, axis=1)) == pytest.approx([1] * 4 + [1.5] * 4 + [3] * 4)
    assert (((box.vertices[box.triangles].mean(axis=1) - box.vertices.mean(axis=0)) * vectors).sum(axis=1) > 0).all()


def test_an_stl_file_is_laid_out_as_the_format_says():
    box = box_mesh()
    data = box.to_stl()
    assert len(data) == 84 + 50 * 12
    assert not data.startswith(b"solid")
    assert b"driftform" in data[:80]
    assert b"mm" in data[:80]
    # admesh prints the header up to the first NUL, and past its end if it has no NUL.
    assert data[79] == 0
    assert int.from_bytes(data[80:84], "little") == 12
    facets = np.frombuffer(data[84:], dtype=[("v", "<f4", (4, 3)), ("attribute", "<u2")])
    normal, corners = facets["v"][:, 0], facets["v"][:, 1:]
    assert (corners == box.vertices[box.triangles]).all()
    # A box's normals are unit vectors along the axes that point away from its middle.
    assert (np.sort(np.abs(normal), axis=1) == [0, 0, 1]).all()
    assert (np.einsum("ij,ij->i", normal, corners.mean(axis=1) - [0.5, 1, 1.5]) > 0).all()


def test_volume_and_surface_of_a_box_are_those_of_the_formulas():
    box = box_mesh()
    assert box.volume == pytest.approx(6, rel=1e-12)
    assert Mesh(box.vertices, box.triangles[:, ::-1]).volume == pytest.approx(-6, rel=1e-12)
    assert Mesh(box.vertices + 1000.0, box.triangles).volume == pytest.approx(6, rel=1e-9)
    assert box.area == pytest.approx(22, rel=1e-12)


def test_a_mesh_is_closed_only_with_every_edge_once_in_each_direction():
    box = box_mesh()
    triangles = box.triangles
    flipped = triangles.copy()
    flipped[0] = flipped[0, ::-1]
    assert box.is_closed
    assert replace(box, triangles=triangles[:, ::-1]).is_closed
    for broken in (triangles[1:], flipped, np.concatenate((triangles, triangles)), triangles[:0]):
        assert not replace(box, triangles=broken).is_closed


def test_merging_joins_equal_coordinates_and_drops_what_collapses():
    vertices = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (-0.0, 0, 0), (1, 1e-12, 0), (1, 1, 0)]
    mesh = Mesh(np.array(vertices, dtype=np.float32), np.array([(0, 1, 2), (3, 4, 5), (0, 3, 1)]))
    merged = mesh.merge_vertices()
    assert merged.vertices.dtype == np.float32
    assert len(merged.vertices) == 5
    assert len(merged.triangles) == 2
    assert not np.signbit(merged.vertices).any()
