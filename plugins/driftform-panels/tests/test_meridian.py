"""How a contour is divided."""

import numpy as np
import pytest

from driftform.agent import solid_of_revolution
from driftform.testing.bodies import cylinder_body, make_body, mirrored_contour, spheroid_body
from driftform_panels import meridian
from driftform_panels.meridian import make_panels
from driftform_panels.solve import solve

CONE = np.array([(0, 0), (0, 0.03), (0.1, 0)], dtype=float)
CUP = np.array([(0, 0), (0, 1), (3, 1), (3, 0.7), (1, 0.7), (1, 0)], dtype=float)


def at(divided, u):
    """Points of all panels at parameter u, (n, 2)."""
    powers = np.array([u**3, u**2, u, 1.0])
    return np.column_stack([divided.x @ powers, divided.r @ powers])


def volume(divided):
    """Volume within the panels, by Gauss's rule, whose eight points are exact for a cubic's r^2 dx."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    total = 0.0
    for u, w in zip((nodes + 1) / 2, weights / 2, strict=True):
        slope = divided.x @ np.array([3 * u * u, 2 * u, 1.0, 0.0])
        total += float(np.pi * w * (at(divided, u)[:, 1] ** 2 @ slope))
    return total


@pytest.mark.parametrize("contour", [CONE, CUP, cylinder_body(0.3, 0.01).outer], ids=["cone", "cup", "cylinder"])
def test_straight_edges_are_followed_exactly_from_axis_to_axis(contour):
    divided = make_panels(contour, 15, 0.2)
    np.testing.assert_allclose(at(divided, 0.0)[0], contour[0], atol=1e-15)
    np.testing.assert_allclose(at(divided, 1.0)[-1], contour[-1], atol=1e-12)
    np.testing.assert_allclose(at(divided, 1.0)[:-1], at(divided, 0.0)[1:], atol=1e-12)
    assert volume(divided) == pytest.approx(solid_of_revolution(contour).volume, rel=1e-12)


def test_a_curve_that_was_drawn_with_short_edges_is_smooth_again():
    fine, coarse = (make_panels(spheroid_body(1.0, 1.0, edges).outer, 15, 0.2) for edges in (1000, 250))
    assert len(fine.lengths) == len(coarse.lengths) < 30
    assert volume(fine) == pytest.approx(4 / 3 * np.pi, rel=1e-5)
    radii = np.linalg.norm(np.concatenate([at(fine, u) for u in np.linspace(0, 1, 21)]), axis=1)
    assert np.abs(radii - 1).max() < 1e-5


def test_random_bodies_keep_their_volume(random_bodies):
    for body in random_bodies(30, 3):
        divided = make_panels(body.outer, 15, 0.2)
        # The dome is a polyline of 2.5 degrees, which loses 3e-4 of the sphere.
        assert volume(divided) == pytest.approx(solid_of_revolution(body.outer).volume, rel=3e-4)


def test_a_zigzag_is_not_a_curve():
    x = np.linspace(0, 0.3, 61)
    r = 0.01 + 0.0001 * (np.arange(61) % 2)
    contour = make_body([(0, 0), *zip(x, r, strict=True), (0.3, 0)]).outer
    divided = make_panels(contour, 15, 0.2)
    assert np.rad2deg(2 * np.arctan(0.0001 / 0.005)) < np.rad2deg(meridian.SMOOTH)
    assert len(divided.lengths) >= 62
    assert volume(divided) == pytest.approx(solid_of_revolution(contour).volume, rel=1e-12)


def test_points_on_a_straight_edge_add_no_panels():
    contour = cylinder_body(3.0, 1.0).outer
    x = np.linspace(-1.5, 1.5, 1000)
    dotted = np.array([(-1.5, 0), *zip(x, np.ones(1000), strict=True), (1.5, 0)])
    assert solve(dotted).surge == pytest.approx(solve(contour).surge, rel=1e-4)
    assert len(make_panels(dotted, 15, 0.2).lengths) == len(make_panels(contour, 15, 0.2).lengths)


def test_panels_get_shorter_towards_sharp_corners_only():
    divided = make_panels(CONE, 15, 0.1)
    joint = np.flatnonzero(np.isclose(at(divided, 1.0)[:, 1], 0.03))[0]
    towards, away = divided.lengths[: joint + 1], divided.lengths[joint + 1 :]
    assert (towards[1:] < 1.02 * towards[:-1]).all()
    assert (away[1:] > 0.98 * away[:-1]).all()
    assert 0.02 * 0.03 < divided.lengths[joint] < 0.1 * 0.03
    blunt = make_panels([(0, 0), (0, 1), (1, 1.2), (2, 1), (2, 0)], 15, 0.1)
    top = np.flatnonzero(np.isclose(at(blunt, 1.0)[:, 0], 1.0))[0]
    assert blunt.lengths[top] > 0.15


def test_the_mirrored_contour_has_the_mirrored_panels(random_bodies):
    for body in random_bodies(10, 4):
        there, back = make_panels(body.outer, 15, 0.2), make_panels(mirrored_contour(body.outer), 15, 0.2)
        np.testing.assert_allclose(back.lengths, there.lengths[::-1], rtol=1e-9)
        for u in (0.0, 0.3, 1.0):
            np.testing.assert_allclose(at(back, u) * (-1, 1), at(there, 1 - u)[::-1], atol=1e-12)


def test_edges_without_length_or_on_the_axis_do_not_count():
    plain = make_panels(CONE, 15, 0.2)
    odd = make_panels([(-1, 0), (0, 0), (0, 0), (0, 0.03), (0, 0.03), (0.1, 0), (0.5, 0)], 15, 0.2)
    np.testing.assert_allclose(odd.x, plain.x, atol=1e-15)
    np.testing.assert_allclose(odd.r, plain.r, atol=1e-15)


@pytest.mark.parametrize(
    "contour",
    [[(0, 0), (1, 0)], [(0, 1), (1, 1), (1, 0)], [(0, 0), (0, 1), (1, 1)], [(0, 0), (0, 1), (1, -0.1), (2, 1), (2, 0)]],
    ids=["nothing", "open aft", "open fore", "beyond the axis"],
)
def test_a_contour_without_a_body_is_refused(contour):
    with pytest.raises(ValueError, match="must start and end on the axis"):
        make_panels(contour, 15, 0.2)


def test_walls_are_known_by_their_thickness():
    assert make_panels(CONE, 15, 0.2).thinnest_wall() == np.inf
    thick, thin = (
        make_panels([(0, 0), (0, 1), (3, 1), (3, 1 - t), (1, 1 - t), (1, 0)], 15, 0.2).thinnest_wall()
        for t in (0.2, 0.02)
    )
    assert thick > 0.3
    assert thin == pytest.approx(thick / 10, rel=0.3)


def test_a_narrow_slot_is_not_a_wall():
    slot = [(0, 0), (0, 1), (1, 1), (1, 0.1), (1.001, 0.1), (1.001, 1), (2, 1), (2, 0)]
    assert make_panels(slot, 15, 0.2).thinnest_wall() > 0.3
