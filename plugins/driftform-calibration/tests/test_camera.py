"""What a film shows of a flight, against a pinhole that looks down and a lens that bends."""

import numpy as np
import pytest

from driftform_calibration.bench import Path
from driftform_calibration.camera import VIEWS, Camera, bend_points, see_points
from driftform_calibration.tracks import Track

T = np.linspace(0.0, 1.0, 31)


def fall():
    """A fall of half a metre from z = 0.2, with a drift to the right."""
    position = np.column_stack([0.1 * T, 0 * T, 0.2 - 0.5 * T**2])
    velocity = np.column_stack([0 * T + 0.1, 0 * T, -T])
    axis = np.tile([1.0, 0.0, 0.0], (len(T), 1))
    return Path(T, position, velocity, axis, 0 * axis, np.inf)


def see(camera):
    blank = Track("film", T, np.zeros((1, len(T), 2)))
    [points] = see_points(fall(), blank, VIEWS["side"], camera)
    return points


def test_before_its_first_sample_a_body_is_held_and_after_its_last_it_moves_on_straight():
    flight = fall()
    found, axis = flight.points_at(np.array([-0.3, 1.2]))
    assert found == pytest.approx(np.array([[0.0, 0.0, 0.2], [0.12, 0.0, -0.3 - 0.2]]))
    assert axis == pytest.approx(flight.axis[:2])


def see_by_pinhole(down, distance):
    """Where a pinhole shows the flight that looks down at the release; lengths as on a ruler upright there."""
    x, _, z = (fall().position - fall().position[0]).T
    depth = distance - z * np.sin(down)
    return np.column_stack([x, z * np.cos(down)]) * (distance / depth)[:, None] / np.cos(down)


@pytest.mark.parametrize("down_deg", [-8.0, 5.0, 8.0])
def test_a_camera_that_looks_down_is_a_keystone_and_a_wider_picture(down_deg):
    down, distance = np.deg2rad(down_deg), 2.0
    camera = Camera(aspect=-np.log(np.cos(down)), keystone=np.sin(down) / distance, offset=(0.0, -0.2))
    # The start is at z = 0.2, from which a pinhole measures.
    assert see(camera) == pytest.approx(see_by_pinhole(down, distance), abs=1e-12)
    flat = see(Camera(offset=(0.0, -0.2)))
    assert np.abs(see_by_pinhole(down, distance) - flat).max() > 0.005


def test_a_barrel_draws_the_farthest_point_in_by_its_share_and_keeps_the_middle():
    points = np.array([[[0.0, 0.0], [2.0, 0.0], [-1.0, 0.0], [-1.0, 0.0]]])
    bent = bend_points(points, 0.03)
    assert bent[0, 1] == pytest.approx([2.0 * 0.97, 0.0])
    assert bent[0, 0] == pytest.approx([0.0, 0.0])
    # A quarter of the square of the distance, and half of it.
    assert bent[0, 2] == pytest.approx([-(1.0 - 0.03 / 4), 0.0])


def test_a_turned_camera_bends_as_an_upright_one():
    straight, turned = see(Camera(barrel=0.02)), see(Camera(barrel=0.02, tilt=0.3))
    c, s = np.cos(0.3), np.sin(0.3)
    assert turned == pytest.approx(straight @ np.array([[c, s], [-s, c]]), abs=1e-12)
