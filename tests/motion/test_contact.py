"""Wall contact: gaps, rims, forces, friction."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from driftform.motion.forces.bore import axis_line, is_clear, transverse_parts
from driftform.motion.forces.contact import deepest_depth, is_far_from_wall, surface_depth, wall_wrench
from driftform.motion.forces.impact import contact_law, damper, spring
from driftform.motion.forces.model import flight_model
from driftform.testing.agents import sphere_agent
from driftform.water import Scenario

PIPE = np.array([[0.0, 0, 0, 1, 0, 0, 9, 1.0]])
OMEGA = 300.0
INERTIA = np.diag([0.4, 0.5, 0.5, 1e-4, 8e-4, 8e-4])
"""Of a body whose added mass is larger across than along."""

angles = st.floats(0, 2 * np.pi)
turns = st.tuples(*[st.floats(-3, 3)] * 3)


def vector(values):
    return tuple(float(value) for value in values)


def rotation(matrix):
    return tuple(vector(row) for row in matrix)


SPHERE = flight_model(sphere_agent(0.02, 0.05), Scenario())


def model_of(surfaces, pipe=PIPE, friction=0.0, restitution=0.7, total=INERTIA):
    """A body with these rims (x, r) or domes (x, 0, radius, and the range of its normals)."""
    rows = np.zeros((len(surfaces), 7))
    for row, surface in zip(rows, surfaces, strict=True):
        row[: len(surface)] = surface
    rows[:, 5], rows[:, 6] = rows[:, 1] ** 2 / pipe[:, 7].min(), total[0, 0]
    numbers = SPHERE.numbers.copy()
    numbers["mass"], numbers["inverse"] = total, np.linalg.inv(total)
    numbers["friction"], numbers["reach"] = friction, (np.hypot(rows[:, 0], rows[:, 1]) + rows[:, 2]).max()
    numbers["law"] = contact_law(numbers["inverse"][0], OMEGA, restitution, 1e-3, 0.02)
    bristles = np.zeros((2 * len(rows) if friction else 0, 3))
    return SPHERE._replace(
        numbers=numbers, surfaces=rows, pipe=pipe, touches=np.zeros((len(rows) + 1, 10)), bristles=bristles
    )


def depth_of(position, R, model, k=0):
    place, axis = vector(position), vector(np.asarray(R)[:, 0])
    parts = transverse_parts(place, axis, model.pipe)
    line = axis_line(parts, model.pipe)
    return surface_depth(place, axis, line, parts, k, model)


def line_of(position, axis, pipe):
    return axis_line(transverse_parts(vector(position), vector(axis), pipe), pipe)


RIM = ((0.1, 0.02),)
TWO_RIMS = ((0.1, 0.02), (-0.05, 0.03))


def force_on(position, velocity=(0, 0, 0), omega=(0, 0, 0), R=None, surfaces=RIM, **parts):
    """Force and torque in body axes; position in the world frame, velocities in body axes."""
    R = np.eye(3) if R is None else np.asarray(R)
    model = model_of(surfaces, **parts)
    return np.concatenate(wall_wrench(vector(position), rotation(R), vector(R @ velocity), vector(omega), model))


def potential(position, R, surfaces, pipe=PIPE):
    """Half of the root of the sum of the squares of twice the springs' energies."""
    model, total = model_of(surfaces, pipe), 0.0
    for k in range(len(surfaces)):
        depth, _, normal, x, r = depth_of(position, R, model, k)
        if depth > 0:
            total += spring(float(R[:, 0] @ normal), x, r, depth, model.numbers[0]["law"])[1] ** 2
    return 0.5 * np.sqrt(total)


def test_a_rim_pressed_into_the_crown_is_pushed_down_by_its_spring_and_pitches_the_body():
    depth = 1e-5
    tau = force_on([2.0, 0, 0.98 + depth], surfaces=((0.0, 0.02),))
    # Pushed at its middle across the axis, all of the mass moves: k = m omega^2.
    assert tau[:3] == pytest.approx([0, 0, -0.5 * OMEGA**2 * depth], rel=1e-3)
    tau = force_on([2.0, 0, 0.98 + depth])
    mass = 1 / (1 / 0.5 + 0.1**2 / 8e-4)
    assert tau[2] == pytest.approx(-mass * OMEGA**2 * depth, rel=1e-3)
    # r x F = (0.1, 0, .) x (0, 0, -F): about +y, nose down.
    assert tau[4] == pytest.approx(-0.1 * tau[2], rel=1e-3)


def test_a_body_clear_of_the_wall_feels_nothing():
    assert force_on([2.0, 0, 0.9]) == pytest.approx(np.zeros(6), abs=0)


def test_the_wall_pushes_harder_on_the_way_in_and_never_pulls_on_the_way_out():
    still = force_on([2.0, 0, 0.9801])[2]
    assert force_on([2.0, 0, 0.9801], velocity=[0, 0, 0.1])[2] < 1.05 * still
    assert 0 >= force_on([2.0, 0, 0.9801], velocity=[0, 0, -0.1])[2] > 0.95 * still
    assert force_on([2.0, 0, 0.9801], velocity=[0, 0, -0.1], restitution=0.1)[2] == 0


@pytest.mark.parametrize("speed", [-0.02, 0.05, 0.2])
def test_rims_that_press_together_are_damped_by_the_mass_that_they_move_together(speed):
    rims, position = ((0.1, 0.02), (0.06, 0.02)), [2.0, 0, 0.98 + 2e-4]
    model = model_of(rims)
    law = model.numbers[0]["law"]
    energies, pushes = [], []
    for k in range(2):
        depth, _, normal, x, r = depth_of(position, np.eye(3), model, k)
        _, energy, force, _ = spring(float(normal[0]), x, r, depth, law)
        energies.append(energy)
        pushes.append(energy * force)
    # They heave and pitch the body: m = (sum F)^2 / ((sum F)^2 / M33 + (sum x F)^2 / M55).
    turn = pushes[0] * 0.1 + pushes[1] * 0.06
    mass = sum(pushes) ** 2 / (sum(pushes) ** 2 / 0.5 + turn**2 / 8e-4)
    assert mass < 0.2
    ratio = force_on(position, [0, 0, speed], surfaces=rims)[2] / force_on(position, surfaces=rims)[2]
    assert ratio == pytest.approx(damper(np.hypot(*energies) / mass, speed, mass, law), rel=1e-6)


def test_a_spinning_body_meets_the_wall_with_the_speed_of_its_rim():
    # Pitch rate q lifts a rim at x by -q x.
    turning = force_on([2.0, 0, 0.9801], omega=[0, -2.0, 0])
    assert turning == pytest.approx(force_on([2.0, 0, 0.9801], velocity=[0, 0, 0.2]), rel=1e-9)


DOME = ((0.01, 0.0, 0.03, -0.5, 1.0), (-0.08, 0.02))


@given(st.sampled_from([TWO_RIMS, DOME]), st.floats(-0.6, 0.6), st.floats(-2e-4, 1.5e-3), angles)
def test_springs_push_and_turn_with_the_gradient_of_one_potential(surfaces, pitch, deep, angle):
    # A rim's closed form is exact in a wide bore: the wall's normal turns by nothing along the body.
    pipe = np.array([[0.0, 0, 0, 1, 0, 0, 9, 1e3]])
    R = Rotation.from_euler("xy", [angle, pitch]).as_matrix()
    out = np.array([0.0, -np.sin(angle), np.cos(angle)])
    reach = max(
        (x * -np.sin(pitch) + r * np.cos(pitch) + more[0] if more else x * -np.sin(pitch) + r * np.cos(pitch))
        for x, r, *more in surfaces
    )
    position = [2.0, 0, 0] + (1e3 - reach + deep) * out
    tau = force_on(position, R=R, surfaces=surfaces, pipe=pipe)
    h, expected = 1e-8, []
    for axis in np.eye(3):
        ends = [potential(position + d * h * R @ axis, R, surfaces, pipe) for d in (1, -1)]
        expected.append((ends[1] - ends[0]) / (2 * h))
    for axis in np.eye(3):
        ends = [
            potential(position, R @ Rotation.from_rotvec(d * h * axis).as_matrix(), surfaces, pipe) for d in (1, -1)
        ]
        expected.append((ends[1] - ends[0]) / (2 * h))
    # A body 1e3 m from the axis: its place is rounded to 1e-13 m.
    size = np.abs(tau).max()
    assert tau == pytest.approx(expected, abs=2e-3 * size + 1e-3)


def test_dividing_a_rim_into_many_neighbours_hardly_stiffens_the_contact():
    one = force_on([2.0, 0, 0.9801], surfaces=((0.0, 0.02),))
    for count in (2, 9):
        many = force_on([2.0, 0, 0.9801], surfaces=((0.0, 0.02),) * count)
        assert many[2] == pytest.approx(np.sqrt(count) * one[2], rel=1e-9)


@given(turns, st.floats(-1, 1), angles)
def test_a_dome_is_pushed_through_its_centre_in_every_attitude(turn, x, angle):
    R = Rotation.from_rotvec(turn).as_matrix()
    out = np.array([0.0, np.cos(angle), np.sin(angle)])
    centre = np.array([2.0, 0, 0]) + (0.97 + 5e-5) * out
    tau = force_on(centre - x * R[:, 0], R=R, surfaces=((x, 0.0, 0.03, -1.0, 1.0),), total=np.eye(6))
    depth, lever, normal, _, _ = depth_of(centre - x * R[:, 0], R, model_of(((x, 0.0, 0.03, -1.0, 1.0),)))
    assert depth == pytest.approx(5e-5, rel=1e-9)
    assert normal == pytest.approx(out, abs=1e-12)
    assert lever == pytest.approx(x * R[:, 0] + 0.03 * out, abs=1e-12)
    pushed = np.cross([x, 0, 0], tau[:3])
    # The mass that a push moves depends on the attitude; its gradient is a moment of half a depth's lever.
    assert tau[3:] == pytest.approx(pushed, abs=5e-5 * np.linalg.norm(tau[:3]))


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
def test_a_rim_that_is_called_clear_or_far_touches_nowhere(pose):
    position, R, x, r, pipe = pose
    line, model = line_of(position, R[:, 0], pipe), model_of([(x, r)], pipe)
    if is_clear(model.surfaces, 0, line) or is_far_from_wall(vector(position), float(np.hypot(x, r)), pipe):
        assert reaches_beyond_the_wall(ring(position, R, x, r), pipe) < 1e-12
        assert depth_of(position, R, model)[0] == 0.0


@given(turns, st.floats(1e-3, 0.1), st.floats(-1, 1), angles)
def test_a_rim_is_as_deep_as_its_farthest_point_but_for_what_the_bore_falls_away(turn, r, share, angle):
    R = Rotation.from_rotvec(turn).as_matrix()
    # The centre lies within a radius of the rim from the wall.
    position = np.array([2.0, (1 + share * r) * np.cos(angle), (1 + share * r) * np.sin(angle)])
    true = max(0.0, reaches_beyond_the_wall(ring(position, R, 0.0, r), PIPE))
    depth, lever, normal, _, _ = depth_of(position, R, model_of([(0.0, r)]))
    # Within r of its farthest point along the normal, the bore of radius 1 falls away by at most r^2 / 2.
    assert true - 0.5 * r * r * (1 + 2 * r) - 1e-3 * r <= depth <= true + 1e-5 * r
    if depth > 0:
        assert np.linalg.norm(normal) == pytest.approx(1.0)
        assert np.linalg.norm((position + lever)[1:]) == pytest.approx(1 + depth, rel=1e-12)
        assert np.linalg.norm(lever) <= r * (1 + 1e-12)


@given(poses())
def test_the_deepest_rim_is_found_behind_all_short_cuts(pose):
    position, R, x, r, pipe = pose
    model = model_of([(x, r), (0.5 * x, 0.9 * r), (0.1 * x, 0.0, 0.8 * r, -0.9, 0.9)], pipe)
    expected = max(depth_of(position, R, model, k)[0] for k in range(3))
    assert deepest_depth(vector(position), rotation(R), model) == expected


def test_the_short_cuts_are_taken_wherever_they_matter():
    middle, ahead = (2.0, 0.1, -0.2), (1.0, 0.0, 0.0)
    assert is_far_from_wall(middle, 0.3, PIPE)
    assert is_clear(model_of([(0.1, 0.05)]).surfaces, 0, line_of(middle, ahead, PIPE))
    assert is_far_from_wall(middle, 5.0, np.empty((0, 8))), "open water has no wall"
    # A body of 0.2 m beside a wall that it does not touch: most of its rims need no closer look.
    rng = np.random.default_rng(1)
    taken = 0
    for _ in range(1000):
        axis = Rotation.random(rng=rng).as_matrix()[:, 0]
        beside = (2.0, *(0.85 * Rotation.random(rng=rng).as_matrix()[0, :2]).tolist())
        taken += is_clear(model_of([(0.05, 0.02)]).surfaces, 0, line_of(beside, axis, PIPE))
    assert taken > 950


# Friction.

PRESSED = [2.0, 0.0, 0.98005]
"""Where a rim of 20 mm radius is 0.05 mm deep in the crown."""
ONE_RIM = ((0.0, 0.02),)


@given(st.floats(0.2, 5), angles, st.floats(0.05, 2))
def test_friction_opposes_sliding_with_mu_times_the_push(speed, angle, mu):
    slide = speed * np.array([np.cos(angle), np.sin(angle), 0.0])
    force = force_on(PRESSED, slide, surfaces=ONE_RIM, friction=mu)[:3]
    assert force[:2] == pytest.approx(mu * force[2] * slide[:2] / speed, rel=1e-2, abs=1e-2 * abs(force[2]))


@given(turns, st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-30, 30)] * 3), angles, st.floats(0, 3))
def test_friction_never_does_work_on_the_body(turn, velocity, omega, angle, mu):
    R = Rotation.from_rotvec(turn).as_matrix()
    position = np.array([2.0, 0.96 * np.cos(angle), 0.96 * np.sin(angle)])
    smooth, rough = (force_on(position, velocity, omega, R, TWO_RIMS, friction=f) for f in (0.0, mu))
    power = (rough - smooth) @ [*velocity, *omega]
    assert power <= 1e-9 * (1 + np.abs(smooth).max())
