"""Contact and overhang of solids for which they are known."""

import numpy as np
import pytest
import trimesh

from driftform_frusta.triangles import Mesh
from driftform_kit.checks.overhangs import choose_orientation, list_orientations

BED = np.array([250.0, 210.0, 210.0])


def ways(mesh, hollow=0):
    return {way.name: way for way in list_orientations(Mesh(mesh.vertices, mesh.faces), hollow)}


def frustum(bottom, top, height):
    return trimesh.creation.revolve(np.array([[0, 0], [bottom, 0], [top, height], [0, height]]), sections=256)


def test_a_box_stands_on_its_side_and_hangs_over_nowhere():
    found = ways(trimesh.creation.box((10, 20, 30)))
    assert [way.contact for way in found.values()] == pytest.approx([200, 200, 300, 600])
    assert [way.overhang for way in found.values()] == pytest.approx([0] * 4)
    assert found["lying"].size == pytest.approx([10, 30, 20])


@pytest.mark.parametrize(("slope_deg", "hangs"), [(40, False), (44.9, False), (45, False), (45.2, True), (60, True)])
def test_a_funnel_hangs_over_where_it_widens_by_more_than_45_degrees(slope_deg, hangs):
    height = 10.0
    top = 5 + height * np.tan(np.radians(slope_deg))
    # A facet of a circle of 256 leans a little less than the cone, by the apothem.
    funnel = frustum(5, top, height)
    found = ways(funnel)
    slant = np.pi * (5 + top) * np.hypot(top - 5, height)
    assert found["as placed"].overhang == pytest.approx(slant if hangs else 0, rel=1e-3, abs=1e-9)
    assert found["as placed"].contact == pytest.approx(np.pi * 25, rel=1e-3)
    assert found["upside down"].overhang == 0
    assert found["upside down"].contact == pytest.approx(np.pi * top**2, rel=1e-3)


def test_a_sphere_hangs_over_below_45_degrees():
    sphere = trimesh.creation.icosphere(subdivisions=5, radius=20)
    # The cap below 45 degrees less what lies in the first layer: 2 pi R times their heights.
    cap = 2 * np.pi * 20 * (20 * (1 - np.sqrt(0.5)) - 0.05)
    for way in ways(sphere).values():
        assert way.overhang == pytest.approx(cap, rel=0.03)
        assert not way.steady


def test_the_ceiling_of_a_closed_hollow_is_told_apart():
    outer, inner = trimesh.creation.box((20, 20, 20)), trimesh.creation.box((10, 12, 14))
    inner.invert()
    found = ways(trimesh.util.concatenate([outer, inner]), hollow=len(inner.faces))["as placed"]
    assert found.overhang == found.enclosed == pytest.approx(120)


def test_the_better_way_is_chosen_and_the_present_one_kept_where_none_is():
    funnel = frustum(5, 30, 10)
    assert choose_orientation(tuple(ways(funnel).values()), BED).name == "upside down"
    funnel.apply_transform(np.diag([1.0, -1.0, -1.0, 1.0]))
    assert choose_orientation(tuple(ways(funnel).values()), BED).name == "as placed"
    cube = tuple(ways(trimesh.creation.box((20, 20, 20))).values())
    assert choose_orientation(cube, BED).name == "as placed"


def test_a_way_that_does_not_fit_the_bed_is_not_the_better_one():
    column = tuple(ways(trimesh.creation.box((10, 10, 200))).values())
    assert choose_orientation(column, BED).name == "lying"
    assert not column[0].fits(np.array([250.0, 210.0, 100.0]))
    assert column[0].fits(np.array([10.0, 10.0, 200.0]))
    assert column[2].fits(np.array([200.0, 10.0, 10.0])) and column[2].fits(np.array([10.0, 200.0, 10.0]))
