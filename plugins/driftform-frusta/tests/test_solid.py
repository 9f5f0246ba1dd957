"""Both interpreters of the tree: what they make of it has the volume that the formulas give."""

import math
import re

import numpy as np
import pytest

from driftform.errors import WorkFailedError
from driftform_frusta.csg import Difference, Extrude, Intersection, Revolve, Rotate, Translate, Union
from driftform_frusta.hull import build_hull
from driftform_frusta.scad import fill_source, write_module
from driftform_frusta.solid import to_manifold, to_solid

SEGMENTS = [3, 12, 13, 64, 1024]


def frustum(height, r0, r1):
    return Revolve(((0, 0), (r0, 0), (r1, height), (0, height)))


BALL = Revolve(tuple((8 * math.sin(a), -8 * math.cos(a)) for a in np.linspace(0, math.pi, 33)))

FIN = Extrude(((0, 0), (9, 0), (9, 4), (2, 4)), (((4, 1), (4, 2), (6, 1)),), 2.0)

BRACKET = Union(
    (
        Translate((15, -2, 2), Rotate((90, 0, 0), FIN)),
        Difference(frustum(5, 20, 20), (Translate((0, 0, -1), frustum(7, 4, 6)),)),
        Translate((0, 0, 20), BALL),
        Translate((5, 5, 4), Rotate((20, -35, 50), frustum(30, 3, 0))),
        Translate((15, 5, 4), Intersection((frustum(10, 4, 4), BALL))),
        Translate((0, 0, -15), Revolve(((-2, 0), (6, 0), (6, 10), (-2, 10)), (((2, 2), (4, 2), (3, 6)),))),
    )
)


def print_source(tree, segments=64):
    return f"{fill_source('definitions', segments=segments)}{write_module('tree', tree)}tree();\n"


def frustum_volume(height, r0, r1):
    return math.pi * height * (r0 * r0 + r0 * r1 + r1 * r1) / 3


def test_a_plate_has_the_area_of_its_outline_less_its_holes():
    solid = to_manifold(FIN)
    assert solid.volume() == pytest.approx(2 * (32 - 1), rel=1e-8)
    assert solid.bounding_box() == pytest.approx((0, 0, 0, 9, 4, 2))


@pytest.mark.parametrize("segments", SEGMENTS)
@pytest.mark.parametrize("radii", [(5, 5), (3, 5), (5, 3), (0, 5), (5, 0)])
def test_a_frustum_has_exactly_the_volume_of_the_formula(radii, segments):
    solid = to_manifold(frustum(7, *radii), segments)
    assert solid.volume() == pytest.approx(frustum_volume(7, *radii), rel=1e-12)
    assert solid.bounding_box()[2::3] == (0, 7)


def test_the_sense_of_rotation_of_a_polygon_does_not_matter():
    outline = ((5, 0), (9, 0), (9, 6), (5, 6))
    hole = ((6, 1), (8, 1), (8, 3))
    a = to_solid(Revolve(outline, (hole,)))
    b = to_solid(Revolve(outline[::-1], (hole[::-1],)))
    assert a.volume == pytest.approx(b.volume, rel=1e-12)


def test_what_lies_beyond_the_axis_is_cut_off_before_revolving():
    crossing = to_manifold(Revolve(((-3, 0), (5, 0), (5, 7), (-4, 7))))
    assert crossing.volume() == pytest.approx(frustum_volume(7, 5, 5), rel=1e-8)
    assert crossing.genus() == 0


def test_angles_are_degrees_about_fixed_x_then_y_then_z():
    turned = to_manifold(Rotate((90, 0, 90), Translate((1, 2, 3), frustum(1, 1, 1)))).bounding_box()
    # x: (1, 2, 3) -> y along z, z along -y; z: -y along x.
    assert np.allclose(turned, (3, 0, 1, 4, 2, 3), atol=2e-3)


@pytest.mark.parametrize(
    "nothing",
    [
        Difference(frustum(1, 1, 1), (Translate((0, 0, -1), frustum(3, 2, 2)),)),
        Intersection((BALL, Translate((20, 0, 0), BALL))),
        Revolve(((1, 0), (2, 0), (1, 1)), (((0, -1), (9, -1), (9, 9), (0, 9)),)),
    ],
)
def test_a_tree_without_a_solid_is_refused(nothing):
    with pytest.raises(WorkFailedError, match="empty or inside out"):
        to_solid(nothing)


def test_source_of_a_hull_stays_on_one_side_of_the_axis_with_six_decimals(body):
    source = print_source(build_hull(body))
    assert source.count("polygon([") == 1 + (len(body.cavity) > 0)
    points = re.findall(r"\[(-?[\d.]+), (-?[\d.]+)\],", source)
    assert len(points) == len(body.outer) + len(body.cavity)
    assert all(float(r) >= 0 for r, _ in points)
    assert not re.search(r"\.\d{7}", source)
    assert not re.search(r"\de[-+]?\d|nan|inf", source)
    assert max(map(len, source.splitlines())) <= 110


@pytest.mark.parametrize("segments", [24, 64])
def test_openscad_and_manifold_make_the_same_solid_of_a_tree_of_all_kinds(segments, render):
    mesh = render(print_source(BRACKET, segments))
    solid = to_manifold(BRACKET, segments)
    assert mesh.volume == pytest.approx(solid.volume(), rel=1e-4)
    assert np.allclose(mesh.bounds.ravel(), solid.bounding_box(), atol=2e-3)
