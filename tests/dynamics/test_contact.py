"""Wall contact: gaps, rims, forces."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from driftform.dynamics.contact import add_wall_forces, rim_point, wall_gap
from driftform.dynamics.model import touching_rims
from driftform.types import Body, Core

PIPE = np.array([[0.0, 0, 0, 9, 0, 0, 1.0]])


def body(*outer):
    return Body(np.array(outer), np.empty((0, 2)), np.array([0.0]), Core(0.01, 0.05), 0.001, 1000.0)


def gap(point, pipe=PIPE):
    normal = np.empty(3)
    return wall_gap(np.array(point, dtype=float), pipe, normal), normal


@given(st.floats(0, 9), st.floats(-2, 2), st.floats(-2, 2))
def test_the_gap_in_a_straight_pipe_is_radius_less_distance_from_the_axis(x, y, z):
    distance, normal = gap([x, y, z])
    assert distance == pytest.approx(1 - np.hypot(y, z), abs=1e-12)
    if np.hypot(y, z) > 1e-3:
        assert normal == pytest.approx(np.array([0, y, z]) / np.hypot(y, z), abs=1e-12)


def test_the_pipe_runs_on_beyond_its_ends():
    assert gap([-0.2, 0, 0.5])[0] == pytest.approx(0.5)
    assert gap([9.4, 0, 0.5])[0] == pytest.approx(0.5)


def test_inside_one_of_two_segments_is_inside_the_pipe():
    elbow = np.array([[0.0, 0, 0, 5, 0, 0, 1.0], [5.0, 0, 0, 5, 0, 4, 1.0]])
    assert gap([5.5, 0, 2.0], elbow)[0] == pytest.approx(0.5)
    assert gap([2.0, 0, -0.5], elbow)[0] == pytest.approx(0.5)
    assert gap([2.0, 0, 2.0], elbow)[0] == pytest.approx(-1.0)


@given(st.tuples(*[st.floats(-3, 3)] * 3), st.floats(0, 6.28), st.floats(0.01, 0.1))
def test_no_point_of_a_rim_lies_farther_along_the_normal_than_its_contact_point(turn, angle, r):
    R = Rotation.from_rotvec(turn).as_matrix()
    normal = np.array([0, np.cos(angle), np.sin(angle)])
    point = np.empty(3)
    rim_point(np.zeros(3), R, 0.05, r, normal, point)
    phi = np.linspace(0, 2 * np.pi, 721)
    rim = np.column_stack([np.full_like(phi, 0.05), r * np.cos(phi), r * np.sin(phi)]) @ R.T
    # A blunt rim touches with a little less than its radius, at most 1e-3 of it (see BLUNT).
    assert (rim @ normal).max() <= point @ normal + 1e-3 * r
    assert (rim @ normal).max() >= point @ normal - 1e-4 * r


def test_only_vertices_of_the_convex_hull_can_touch():
    waist = body((-0.1, 0), (-0.1, 0.03), (0.0, 0.01), (0.05, 0.025), (0.1, 0.03), (0.1, 0))
    assert touching_rims(waist) == pytest.approx(np.array([[-0.1, 0.03], [0.1, 0.03]]))
    cone = body((-0.1, 0), (-0.1, 0.05), (0.1, 0))
    assert touching_rims(cone) == pytest.approx(np.array([[-0.1, 0.05]]))


def force_on(position, velocity=(0, 0, 0), omega=(0, 0, 0), R=None, rims=((0.1, 0.02, 1000.0, 20.0),)):
    tau = np.zeros(6)
    add_wall_forces(
        np.array(position, dtype=float),
        np.eye(3) if R is None else R,
        np.array(velocity, dtype=float),
        np.array(omega, dtype=float),
        np.array(rims),
        PIPE,
        tau,
    )
    return tau


def test_a_rim_pressed_into_the_crown_is_pushed_down_by_its_spring_and_pitches_the_body():
    tau = force_on([2.0, 0, 0.99])
    assert tau[:3] == pytest.approx([0, 0, -1000 * 0.01], rel=1e-5)
    # r x F = (0.1, 0, .) x (0, 0, -10): about +y, nose down.
    assert tau[3:] == pytest.approx([0, 1.0, 0], rel=1e-5, abs=1e-12)


def test_a_body_clear_of_the_wall_feels_nothing():
    assert force_on([2.0, 0, 0.9]) == pytest.approx(np.zeros(6), abs=0)


def test_the_wall_pushes_harder_on_the_way_in_and_never_pulls_on_the_way_out():
    inward = force_on([2.0, 0, 0.99], velocity=[0, 0, 0.1])
    outward = force_on([2.0, 0, 0.99], velocity=[0, 0, -5.0])
    assert inward[2] == pytest.approx(-(1000 * 0.01 + 20 * 0.1), rel=1e-5)
    assert outward == pytest.approx(np.zeros(6), abs=0)


def test_a_spinning_body_meets_the_wall_with_the_speed_of_its_rim():
    # Pitch rate q lifts a rim at x by -q x.
    tau = force_on([2.0, 0, 0.99], omega=[0, -2.0, 0])
    assert tau[2] == pytest.approx(-(1000 * 0.01 + 20 * 0.2), rel=1e-5)


TWO_RIMS = ((0.1, 0.02, 1000.0, 20.0), (-0.05, 0.03, 700.0, 10.0))


def potential(position, R, rims=TWO_RIMS):
    """sqrt(sum of s^4) / 2 with s^2 = k d^2, the depths found by going around each rim."""
    phi = np.linspace(0, 2 * np.pi, 200_001)
    total = 0.0
    for x, r, k, _ in rims:
        rim = np.column_stack([np.full_like(phi, x), r * np.cos(phi), r * np.sin(phi)]) @ R.T + position
        depth = max(0.0, np.hypot(rim[:, 1], rim[:, 2]).max() - 1)
        total += (k * depth**2) ** 2
    return np.sqrt(total) / 2


@pytest.mark.parametrize("height", [0.972, 0.985, 1.0])
def test_the_push_of_several_rims_is_the_gradient_of_one_potential(height):
    R = Rotation.from_rotvec([0, 0.1, 0]).as_matrix()
    h = 1e-5
    up, down = (potential(np.array([2.0, 0, height + d]), R) for d in (h, -h))
    push = R @ force_on([2.0, 0, height], R=R, rims=TWO_RIMS)[:3]
    assert push[2] == pytest.approx(-(up - down) / (2 * h), rel=1e-3)


def test_dividing_a_rim_into_many_neighbours_hardly_stiffens_the_contact():
    one = force_on([2.0, 0, 0.99], rims=((0.0, 0.02, 1000.0, 0.0),))
    for count in (2, 9):
        many = force_on([2.0, 0, 0.99], rims=((0.0, 0.02, 1000.0, 0.0),) * count)
        assert many[2] == pytest.approx(np.sqrt(count) * one[2], rel=1e-9)


@given(st.floats(-0.3, 0.3))
def test_a_mirrored_body_is_pushed_in_the_mirrored_way(pitch):
    here, there = (Rotation.from_rotvec([0, s * pitch, 0]).as_matrix() for s in (1, -1))
    mirrored = tuple((-x, r, k, c) for x, r, k, c in TWO_RIMS)
    tau = here @ force_on([2.0, 0, 0.985], R=here, rims=TWO_RIMS).reshape(2, 3).T
    mirror = there @ force_on([2.0, 0, 0.985], R=there, rims=mirrored).reshape(2, 3).T
    assert mirror[2, 0] == pytest.approx(tau[2, 0], rel=1e-9, abs=1e-12)
    assert mirror[1, 1] == pytest.approx(-tau[1, 1], rel=1e-9, abs=1e-12)


def test_contact_is_frictionless():
    assert force_on([2.0, 0, 0.99], velocity=[3.0, 0, 0])[0] == pytest.approx(0, abs=1e-12)


@given(st.floats(0, 6.28))
def test_contact_is_the_same_all_around_the_pipe(angle):
    turn = Rotation.from_rotvec([angle, 0, 0]).as_matrix()
    here = force_on([2.0, 0, 0.99], velocity=[0.5, 0.0, 0.1])
    there = force_on(turn @ [2.0, 0, 0.99], velocity=turn @ [0.5, 0.0, 0.1])
    assert there[:3] == pytest.approx(turn @ here[:3], abs=1e-9)
    assert there[3:] == pytest.approx(turn @ here[3:], abs=1e-9)
