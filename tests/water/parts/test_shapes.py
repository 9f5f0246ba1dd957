"""Parts of a pipe in their places: axes, ends, and what lies inside."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from driftform.water.parts.shapes import (
    VERTICAL,
    Bend,
    Reducer,
    Straight,
    Tee,
    exact_cosine,
    exact_sine,
    roll_axes,
    tee_legs,
    upright_axes,
)

LEVEL = np.eye(3)
ORIGIN = np.zeros(3)

directions = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: np.linalg.norm(d) > 0.1)


@given(directions, st.floats(-7, 7))
@example((0.0, 1e-12, 0.5), 0.0)
def test_axes_are_right_handed_and_the_third_points_up(direction, roll):
    axes = upright_axes(np.array(direction))
    for frame in (axes, roll_axes(axes, roll)):
        assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(frame) == pytest.approx(1.0)
        assert frame[0] == pytest.approx(np.array(direction) / np.linalg.norm(direction), abs=1e-12)
    riser = np.hypot(*axes[0, :2]) < VERTICAL
    assert axes[2, 2] >= (-VERTICAL if riser else 0) and abs(axes[1, 2]) < (VERTICAL if riser else 1e-12)


@pytest.mark.parametrize(("clock", "up"), [(0, (0, 0, 1)), (90, (0, -1, 0)), (180, (0, 0, -1)), (270, (0, 1, 0))])
def test_a_roll_is_the_hand_of_a_clock_seen_downstream(clock, up):
    # Looking along x with z up, y is on the left.
    assert roll_axes(LEVEL, math.radians(clock))[2].tolist() == list(up)


def test_how_a_riser_leans_does_not_turn_its_clock():
    for heading in np.linspace(0, 2 * np.pi, 13):
        for sign in (1.0, -1.0):
            lean = 5e-4 * np.array([np.cos(heading), np.sin(heading), 0.0])
            axes = upright_axes(lean + np.array([0.0, 0.0, sign]))
            np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
            np.testing.assert_allclose(axes, upright_axes(np.array([0.0, 0.0, sign])), atol=6e-4)


def test_a_vertical_bore_keeps_the_axes_of_the_bore_before_it():
    bend = Bend(ORIGIN, LEVEL, 0.1, 0.3, math.pi / 2)
    [exit_] = bend.list_exits()
    assert exit_.axes[0] == pytest.approx([0, 0, 1])
    assert upright_axes(exit_.axes[0], exit_.axes) is exit_.axes
    assert upright_axes(exit_.axes[0]) == pytest.approx(exit_.axes), "the same as without a bore before it, along x"


def test_sines_of_right_angles_are_exact():
    assert [exact_sine(k * math.pi / 2) for k in range(-4, 5)] == [0, 1, 0, -1, 0, 1, 0, -1, 0]
    assert exact_cosine(1.0) == pytest.approx(math.cos(1.0), abs=1e-15)


@given(st.floats(0.01, math.pi), st.floats(0.11, 2.0), st.floats(-4, 4))
def test_a_bend_ends_where_its_axis_does_and_turns_by_its_angle(angle, radius, roll):
    bend = Bend(np.array([1.0, 2.0, 3.0]), roll_axes(LEVEL, roll), 0.1, radius, angle)
    [axis], [exit_] = bend.list_axes(0.001 * radius), bend.list_exits()
    assert axis.points[-1] == pytest.approx(exit_.centre, abs=1e-9)
    assert bend.length == pytest.approx(np.linalg.norm(np.diff(axis.points, axis=0), axis=1).sum(), rel=1e-5)
    assert exit_.axes[0] @ bend.axes[0] == pytest.approx(math.cos(angle), abs=1e-12)
    centre = bend.origin + radius * bend.axes[2]
    assert np.linalg.norm(axis.points - centre, axis=1) == pytest.approx(radius)


@given(st.floats(0.01, 0.5), st.floats(0.01, 0.5), st.floats(2.0, 20.0))
def test_the_ogee_of_a_reducer_is_smooth_and_monotone(first, last, slenderness):
    if abs(first - last) < 1e-3:
        return
    reducer = Reducer(ORIGIN, LEVEL, first, last, slenderness * abs(first - last))
    x = np.linspace(0, reducer.length, 2001)
    r = reducer.bore_radii(x)
    assert r[[0, -1]] == pytest.approx([first, last])
    assert (np.diff(r) * np.sign(last - first) >= -1e-15).all()
    slope = np.gradient(r, x)
    assert slope[[0, -1]] == pytest.approx([0, 0], abs=0.01)
    assert np.abs(np.diff(slope)).max() < 5 * np.abs(last - first) / reducer.length / 500


@given(st.floats(0.02, 0.1), st.floats(30, 150), st.floats(0.1, 0.5))
def test_the_legs_of_a_tee_end_beyond_its_rounded_edge(branch, degrees, fillet):
    angle, radius = math.radians(degrees), 0.1
    up, down, side = tee_legs(radius, branch, angle, fillet * branch)
    # The edge of two bores whose radii are larger by the fillet: where both distances from the axes are these radii.
    phi = np.linspace(0, 2 * np.pi, 721)
    rho, height = branch * (1 + fillet), radius + fillet * branch
    along = (
        np.sqrt(height**2 - np.minimum(height, rho * np.abs(np.sin(phi))) ** 2) + rho * np.cos(phi) * np.cos(angle)
    ) / np.sin(angle)
    x = along * np.cos(angle) + rho * np.cos(phi) * np.sin(angle)
    assert -x.min() == pytest.approx(up - 2 * radius, abs=1e-4)
    assert x.max() == pytest.approx(down - 2 * radius, abs=1e-4)
    assert along.max() == pytest.approx(side - 2 * branch, abs=1e-4)


@pytest.mark.parametrize(
    "part",
    [
        Straight(ORIGIN, LEVEL, 0.1, 0.5),
        Bend(ORIGIN, LEVEL, 0.1, 0.3, 3.0),
        Reducer(ORIGIN, LEVEL, 0.1, 0.05, 0.2),
        Reducer(ORIGIN, LEVEL, 0.05, 0.1, 0.2),
        Tee(ORIGIN, LEVEL, 0.1, 0.05, math.radians(60), 0.01, 0.3),
    ],
    ids=lambda part: type(part).__name__,
)
def test_the_bores_volume_is_what_lies_inside(part):
    rng = np.random.default_rng(0)
    low, high = np.array([-0.7, -0.15, -0.15]), np.array([0.7, 0.15, 0.8])
    inside = part.find_inside(rng.uniform(low, high, (400_000, 3)))
    volume = inside.mean() * np.prod(high - low)
    if isinstance(part, Tee):
        _, _, side = part.legs
        # The branch adds its cylinder beyond the run, whose end is a slanted cut: its mean length is that along the axis.
        mean = 0.1 / math.sin(part.angle) * np.sqrt(1 - 0.25 * np.linspace(0, 1, 201) ** 2).mean()
        expected = math.pi * 0.1**2 * part.length + math.pi * 0.05**2 * (side - mean)
        assert volume == pytest.approx(expected, rel=0.02)
        return
    [axis] = part.list_axes(0.001)
    areas = math.pi * axis.radii**2
    assert volume == pytest.approx(np.trapezoid(areas, np.linspace(0, part.length, len(areas))), rel=0.02)
