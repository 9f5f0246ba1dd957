"""Wall contact: gaps, rims, forces, friction."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from driftform.dynamics.contact import (
    SLIP_SPEED,
    axis_line,
    deepest_rim_depth,
    farthest_rim_point,
    is_clear,
    is_far_from_wall,
    rim_depth,
    wall_gap,
    wall_wrench,
)
from driftform.dynamics.model import flight_model, touching_rims
from driftform.scenario import Contact, Pipe, Scenario, Segment
from driftform.testing.agents import Spheroid
from driftform.types import Body, Core

PIPE = np.array([[0.0, 0, 0, 1, 0, 0, 9, 1.0]])
ELBOW = np.array([[0.0, 0, 0, 1, 0, 0, 5, 1.0], [5.0, 0, 0, 0, 0, 1, 4, 1.0]])
RATE = 200.0

angles = st.floats(0, 2 * np.pi)
turns = st.tuples(*[st.floats(-3, 3)] * 3)


def vector(values):
    return tuple(float(value) for value in values)


def rotation(matrix):
    return tuple(vector(row) for row in matrix)


def body(*outer):
    return Body(np.array(outer), np.empty((0, 2)), np.array([0.0]), Core(0.01, 0.05), 0.001, 1000.0)


def gap(point, pipe=PIPE):
    distance, normal = wall_gap(vector(point), pipe)
    return distance, np.array(normal)


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
    assert gap([5.5, 0, 2.0], ELBOW)[0] == pytest.approx(0.5)
    assert gap([2.0, 0, -0.5], ELBOW)[0] == pytest.approx(0.5)
    assert gap([2.0, 0, 2.0], ELBOW)[0] == pytest.approx(-1.0)


@given(st.floats(-1, 7), st.floats(-2, 2), st.floats(-2, 5))
def test_the_gap_in_an_elbow_is_that_of_the_segment_which_the_point_is_deepest_in(x, y, z):
    # The first runs on upstream, the second downstream; where they meet each ends in a sphere.
    first = 1 - np.hypot(np.hypot(y, z), max(x - 5, 0))
    second = 1 - np.hypot(np.hypot(x - 5, y), max(-z, 0))
    assert gap([x, y, z], ELBOW)[0] == pytest.approx(max(first, second), abs=1e-12)


@given(turns, angles, st.floats(0.01, 0.1))
def test_no_point_of_a_rim_lies_farther_along_the_normal_than_its_contact_point(turn, angle, r):
    R = Rotation.from_rotvec(turn).as_matrix()
    normal = np.array([0, np.cos(angle), np.sin(angle)])
    point = np.array(farthest_rim_point(vector(0.05 * R[:, 0]), vector(R[:, 0]), r, vector(normal)))
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


def rows(rims, pipe=PIPE, mass=1.0):
    """Rims of x, r, spring and damper as the kernels read them."""
    narrowest = pipe[:, 7].min()
    return np.array([[x, r, k, c, mass, r * r / narrowest] for x, r, k, c in rims])


def force_on(
    position,
    velocity=(0, 0, 0),
    omega=(0, 0, 0),
    R=None,
    rims=((0.1, 0.02, 1000.0, 20.0),),
    pipe=PIPE,
    friction=0.0,
    mass=1.0,
):
    """Force and torque in body axes; position in the world frame, velocities in body axes."""
    table, R = rows(rims, pipe, mass), np.eye(3) if R is None else np.asarray(R)
    wrench = wall_wrench(
        vector(position),
        rotation(R),
        vector(R @ velocity),
        vector(omega),
        table,
        float(np.hypot(table[:, 0], table[:, 1]).max()),
        pipe,
        friction,
        RATE,
    )
    return np.concatenate(wrench)


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


def test_contact_without_a_coefficient_of_friction_is_frictionless():
    assert force_on([2.0, 0, 0.99], velocity=[3.0, 0, 0])[0] == pytest.approx(0, abs=1e-12)


@given(angles)
def test_contact_is_the_same_all_around_the_pipe(angle):
    turn = Rotation.from_rotvec([angle, 0, 0]).as_matrix()
    here = force_on([2.0, 0, 0.99], velocity=[0.5, 0.0, 0.1])
    there = force_on(turn @ [2.0, 0, 0.99], velocity=turn @ [0.5, 0.0, 0.1])
    assert there[:3] == pytest.approx(turn @ here[:3], abs=1e-9)
    assert there[3:] == pytest.approx(turn @ here[3:], abs=1e-9)


# The short cuts that pass rims by.


def ring(position, R, x, r, count=720):
    phi = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return position + np.column_stack([np.full_like(phi, x), r * np.cos(phi), r * np.sin(phi)]) @ R.T


@st.composite
def poses(draw):
    """A pipe in any direction, and a rim in it in any attitude, as often near the wall as far from it."""
    size = draw(st.floats(0.05, 2))
    r = size * draw(st.floats(1e-3, 0.9))
    x = size * draw(st.floats(-1, 1))
    frame = Rotation.from_rotvec(draw(turns)).as_matrix()
    start = np.array(draw(st.tuples(*[st.floats(-5, 5)] * 3)))
    pipe = np.array([[*start, *frame[:, 0], 9.0, size]])
    angle = draw(angles)
    # The body's axis: anywhere, along the pipe, or towards its wall, so that the rim touches at its sides if at all.
    along, towards = frame, frame @ Rotation.from_euler("zx", [np.pi / 2, angle]).as_matrix()
    R = draw(st.sampled_from([Rotation.from_rotvec(draw(turns)).as_matrix(), along, towards]))
    # The rim's centre: at any distance from the axis, or where the rim just touches.
    flat = np.sqrt(size**2 - r**2) if R is towards else size - r
    off = draw(st.one_of(st.floats(0, 1.1 * size), st.floats(-0.1 * r, 0.1 * r).map(lambda d: flat + d)))
    centre = start + frame @ [draw(st.floats(0, 9)), off * np.cos(angle), off * np.sin(angle)]
    return centre - x * R[:, 0], R, x, r, pipe


def reaches_beyond_the_wall(points, pipe):
    off = points - pipe[0, :3]
    across = off - np.outer(off @ pipe[0, 3:6], pipe[0, 3:6])
    return np.linalg.norm(across, axis=1).max() - pipe[0, 7]


@given(poses())
def test_a_rim_that_is_called_clear_touches_nowhere(pose):
    position, R, x, r, pipe = pose
    line = axis_line(vector(position), vector(R[:, 0]), pipe)
    if is_clear(rows([(x, r, 1.0, 0.0)], pipe), 0, line):
        assert reaches_beyond_the_wall(ring(position, R, x, r), pipe) < 1e-12
        assert rim_depth(vector(position), vector(R[:, 0]), x, r, pipe)[0] == 0.0


@given(poses())
def test_a_body_that_is_called_far_touches_nowhere(pose):
    position, R, x, r, pipe = pose
    reach = float(np.hypot(x, r))
    if is_far_from_wall(vector(position), reach, pipe):
        assert reaches_beyond_the_wall(ring(position, R, x, r), pipe) < 1e-12
        assert rim_depth(vector(position), vector(R[:, 0]), x, r, pipe)[0] == 0.0


@given(turns, st.floats(1e-3, 0.1), st.floats(-1, 1), angles)
def test_a_rim_is_as_deep_as_its_farthest_point_but_for_what_the_bore_falls_away(turn, r, share, angle):
    R = Rotation.from_rotvec(turn).as_matrix()
    # The centre lies within a radius of the rim from the wall.
    position = np.array([2.0, (1 + share * r) * np.cos(angle), (1 + share * r) * np.sin(angle)])
    true = max(0.0, reaches_beyond_the_wall(ring(position, R, 0.0, r), PIPE))
    depth, point, normal = rim_depth(vector(position), vector(R[:, 0]), 0.0, r, PIPE)
    # Within r of its farthest point along the normal, the bore of radius 1 falls away by at most r^2 / 2.
    assert true - 0.5 * r * r * (1 + 2 * r) - 1e-3 * r <= depth <= true + 1e-5 * r
    if depth > 0:
        assert np.linalg.norm(normal) == pytest.approx(1.0)
        assert np.hypot(point[1], point[2]) == pytest.approx(1 + depth, rel=1e-12)
        assert np.linalg.norm(np.subtract(point, position)) <= r * (1 + 1e-12)


@given(poses(), st.booleans(), turns, turns, st.sampled_from([0.0, 0.4]))
def test_a_pipe_in_two_pieces_pushes_like_a_whole_one(pose, coplanar, velocity, omega, friction):
    # In pieces it is a network, whose walls are looked for point by point; in one there are closed forms.
    position, R, x, r, pipe = pose
    start, downstream, size = pipe[0, :3], pipe[0, 3:6], pipe[0, 7]
    if coplanar:
        along = (position - start) @ downstream
        out = position - start - along * downstream
        side = np.cross(downstream, out) if np.linalg.norm(out) > 1e-3 else np.cross(downstream, R[:, 1])
        side /= np.linalg.norm(side)
        ahead = R[:, 0] - (R[:, 0] @ side) * side
        ahead /= np.linalg.norm(ahead)
        R = np.column_stack([ahead, side, np.cross(ahead, side)])
    rims = [(x, r, 900.0, 20.0), (x - 0.3 * r, 0.8 * r, 700.0, 15.0), (-x, 0.5 * r, 500.0, 10.0)]
    pieces = np.array([[*start, *downstream, 4.0, size], [*(start + 4 * downstream), *downstream, 5.0, size]])
    whole, parts = (force_on(position, velocity, omega, R, rims, lines, friction) for lines in (pipe, pieces))
    # What the first look at a rim calls clear, but its second look would not, is deeper by less than a micrometre.
    assert whole == pytest.approx(parts, rel=1e-5, abs=1e-5)


@given(poses())
def test_the_deepest_rim_is_found_behind_all_short_cuts(pose):
    position, R, x, r, pipe = pose
    rims = rows([(x, r, 1.0, 0.0), (0.5 * x, 0.9 * r, 1.0, 0.0)], pipe)
    expected = max(rim_depth(vector(position), vector(R[:, 0]), *rim[:2].tolist(), pipe)[0] for rim in rims)
    reach = float(np.hypot(rims[:, 0], rims[:, 1]).max())
    assert deepest_rim_depth(vector(position), rotation(R), rims, reach, pipe) == expected


def test_the_short_cuts_are_taken_wherever_they_matter():
    middle, ahead = (2.0, 0.1, -0.2), (1.0, 0.0, 0.0)
    assert is_far_from_wall(middle, 0.3, PIPE)
    assert is_clear(rows([(0.1, 0.05, 1.0, 0.0)]), 0, axis_line(middle, ahead, PIPE))
    assert is_far_from_wall(middle, 5.0, np.empty((0, 8))), "open water has no wall"
    # A body of 0.2 m beside a wall that it does not touch: most of its rims need no closer look.
    rng = np.random.default_rng(1)
    taken = 0
    for _ in range(1000):
        axis = Rotation.random(rng=rng).as_matrix()[:, 0]
        beside = (2.0, *(0.85 * Rotation.random(rng=rng).as_matrix()[0, :2]).tolist())
        taken += is_clear(rows([(0.05, 0.02, 1.0, 0.0)]), 0, axis_line(beside, vector(axis), PIPE))
    assert taken > 950


@given(st.floats(0, 6), st.floats(-0.9, 0.9), st.floats(-0.9, 3), st.floats(0.01, 2))
def test_no_point_within_reach_of_a_body_far_from_an_elbows_wall_is_outside(x, y, z, reach):
    if not is_far_from_wall((x, y, z), reach, ELBOW):
        return
    ball = np.random.default_rng(1).normal(size=(50, 3))
    ball *= reach / np.linalg.norm(ball, axis=1, keepdims=True)
    assert min(gap(point, ELBOW)[0] for point in ball + np.array([x, y, z])) > -1e-12


# Segments that meet.


def test_a_pipe_of_two_segments_in_line_is_one_pipe():
    pipe = np.array([[0.0, 0, 0, 1, 0, 0, 4, 1.0], [4.0, 0, 0, 1, 0, 0, 5, 1.0]])
    R = Rotation.from_rotvec([0.2, -0.1, 0.3]).as_matrix()
    for x in (3.7, 3.95, 4.0, 4.2):
        here, there = (
            force_on([x, 0.3, 0.93], [0.4, -0.1, 0.2], [0.3, 1.0, -0.2], R, TWO_RIMS, p, friction=0.4)
            for p in (PIPE, pipe)
        )
        assert np.abs(here).max() > 1.0
        assert there == pytest.approx(here, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("side", [0.0, 0.4, -0.9])
def test_the_push_of_the_wall_is_continuous_round_the_outside_of_an_elbow(side):
    # The middle of a rim of 5 mm goes round the corner 2 mm from where it would touch at its side.
    r, k = 0.005, 1000.0
    phi = np.linspace(-0.3, 0.5 * np.pi + 0.3, 20_001)
    out = np.column_stack([np.sin(phi), np.full_like(phi, side), -np.cos(phi)])
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    # Beyond the sphere about the joint, the bores are cylinders, on whose wall the path goes on.
    sides = np.hypot(out[:, 1], np.where(phi < 0, out[:, 2], np.where(phi > np.pi / 2, out[:, 0], 1)))
    way = out / np.where((phi < 0) | (phi > np.pi / 2), sides, 1)[:, None] * (1 + 0.002)
    way += (5.0, 0.0, 0.0)
    force = np.array([force_on(p, rims=((0.0, r, k, 0.0),), pipe=ELBOW)[:3] for p in way[::20]])
    assert np.linalg.norm(force, axis=1).min() > 0.9 * k * 0.002
    step = np.linalg.norm(np.diff(way[::20], axis=0), axis=1)
    change = np.linalg.norm(np.diff(force, axis=0), axis=1)
    # |d(k d n)| <= k |dp| + k d |dn|: the normal turns by no more than dp / R, twice that for the rim's own point.
    deepest = 0.002 + r
    assert (change <= k * step * (1 + 3 * deepest) * 1.01 + 1e-9).all()


@pytest.mark.parametrize("side", [0.0, 0.3])
def test_a_rim_that_crosses_the_inner_corner_of_an_elbow_is_always_pushed_back_into_a_bore(side):
    r, k = 0.005, 1000.0
    for x in np.linspace(3.8, 4.02, 45):
        z = 5.0 - x + 0.003
        position = np.array([x, side, z])
        force = force_on(position, rims=((0.0, r, k, 0.0),), pipe=ELBOW)[:3]
        if gap(position, ELBOW)[0] < -r:
            moved = position + 1e-3 * force / np.linalg.norm(force)
            assert gap(moved, ELBOW)[0] > gap(position, ELBOW)[0]


# Friction.

ONE_RIM = ((0.0, 0.02, 1000.0, 20.0),)
PRESS = 1000.0 * 0.01
PRESSED = [2.0, 0.0, 0.99]
"""Where a rim of 20 mm radius is 10 mm deep in the crown: the wall presses with 10 N."""


@given(st.floats(0.2, 5), angles, st.floats(0.05, 2))
def test_friction_opposes_sliding_with_mu_times_the_push(speed, angle, mu):
    slide = speed * np.array([np.cos(angle), np.sin(angle), 0.0])
    force = force_on(PRESSED, slide, rims=ONE_RIM, friction=mu, mass=1e3)[:3]
    assert force[2] == pytest.approx(-PRESS, rel=1e-5)
    # Well above the speed s below which it is smooth: off by s^2 / (2 v^2).
    assert force[:2] == pytest.approx(
        -mu * PRESS * slide[:2] / speed, abs=mu * PRESS * (SLIP_SPEED / speed) ** 2
    )


def test_a_rim_that_does_not_slide_feels_no_friction():
    for velocity in ([0, 0, 0], [0, 0, 0.3]):
        still, rough = (force_on(PRESSED, velocity, rims=ONE_RIM, friction=mu) for mu in (0.0, 0.7))
        assert rough == pytest.approx(still, abs=1e-12)


def test_a_rim_that_rolls_along_the_wall_does_not_slide():
    # The rim's lowest point, at r from the axis, stands still where the axis moves with -w x r.
    r = 0.02 / np.sqrt(1 + 1e-6)  # what is blunt about a rim takes 5e-7 of its radius
    rolling = force_on(PRESSED, [0, 3.0 * r, 0], [3.0, 0, 0], rims=ONE_RIM, friction=0.7)
    sliding = force_on(PRESSED, [0, 3.0 * r, 0], rims=ONE_RIM, friction=0.7)
    assert rolling[1] == pytest.approx(0, abs=1e-6)
    assert sliding[1] < -6


def test_sliding_along_the_axis_does_not_roll_a_level_body():
    table = ((0.1, 0.02, 1000.0, 20.0), (-0.1, 0.02, 1000.0, 20.0))
    force = force_on(PRESSED, [1.5, 0, 0], rims=table, friction=0.5, mass=1e3)
    assert force[0] < -0.4 * PRESS
    assert force[3] == 0.0
    assert force[5] == 0.0
    # At the crown it pulls the body's top back: nose up, with the arm r.
    assert force[4] == pytest.approx(0.02 * force[0], rel=1e-4)


@given(
    turns, st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-30, 30)] * 3), angles, st.floats(0, 3)
)
def test_friction_never_does_work_on_the_body(turn, velocity, omega, angle, mu):
    R = Rotation.from_rotvec(turn).as_matrix()
    position = np.array([2.0, 0.96 * np.cos(angle), 0.96 * np.sin(angle)])
    smooth, rough = (force_on(position, velocity, omega, R, TWO_RIMS, friction=f) for f in (0.0, mu))
    power = (rough - smooth) @ [*velocity, *omega]
    assert power <= 1e-9 * (1 + np.abs(smooth).max())


@given(st.floats(1e-4, 10), st.floats(0.1, 3), angles)
def test_friction_grows_with_slip_no_faster_than_its_rate_allows(mass, mu, angle):
    def friction(slip):
        slide = slip * np.array([np.cos(angle), np.sin(angle), 0.0])
        return -force_on(PRESSED, slide, rims=ONE_RIM, friction=mu, mass=mass)[:2] @ slide[:2] / slip

    # Force over slip is greatest where the slip vanishes, and with it the rate at which slip would decay.
    slopes = [friction(slip) / slip / mass for slip in (1e-7, 1e-3, 1e-2, 0.1, 1.0)]
    assert slopes == sorted(slopes, reverse=True)
    assert slopes[0] <= RATE * (1 + 1e-9)
    assert slopes[0] == pytest.approx(min(RATE, mu * PRESS / (SLIP_SPEED * mass)), rel=1e-5)
    assert friction(10 * max(SLIP_SPEED, mu * PRESS / (mass * RATE))) > 0.99 * mu * PRESS


def test_the_mass_that_limits_friction_is_the_least_that_a_rim_opposes_to_a_push_along_the_wall():
    spheroid = Spheroid(0.06, 0.01)
    pipe = Pipe(segments=(Segment(start=(0, 0, 0), end=(9, 0, 0), radius=1),))
    scenario = Scenario(pipe=pipe, contact=Contact(friction=0.3))
    model = flight_model(spheroid.agent(), scenario)
    along, across, turning = spheroid.total
    roll = 0.4 * spheroid.mass * spheroid.b**2
    for x, r, spring, _, opposed, _ in model.rims:
        assert spring == pytest.approx(70.0**2 / (1 / across + x**2 / turning), rel=1e-9)
        axially = 1 / (1 / along + r**2 / turning)
        around = 1 / (1 / across + r**2 / roll + x**2 / turning)
        assert opposed == pytest.approx(min(axially, around), rel=1e-9)
