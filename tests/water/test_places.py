"""Places in a pipe by name are the points that a surveyor would find."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.errors import InputError
from driftform.study import load_study
from driftform.water import Pipe
from driftform.water.places import find_nearest_inside, resolve_place

BENT = Pipe.model_validate(
    {
        "radius": 0.15,
        "parts": [
            {"kind": "straight", "length": 2.0},
            {"kind": "bend", "angle_deg": 90, "radius": 0.5, "roll_deg": 90},
            {"kind": "straight", "length": 3.0},
        ],
    }
).layout


def place(**values):
    return list(resolve_place(values, BENT))


def test_twelve_is_the_crown_and_six_the_floor_and_three_the_right_seen_downstream():
    assert place(part="straight 1", at=0.5, clock=12, off_wall=0.03) == pytest.approx([0.5, 0.0, 0.12])
    assert place(part="straight 1", at=0.5, clock=6, off_wall=0.03) == pytest.approx([0.5, 0.0, -0.12])
    assert place(part="straight 1", at=0.5, clock=3, off_wall=0.0) == pytest.approx([0.5, -0.15, 0.0])


def test_behind_a_bend_to_the_right_a_place_turns_with_the_pipe():
    assert place(part="straight 2", at=1.2) == pytest.approx([2.5, -0.5 - 1.2, 0.0])
    assert place(part="straight 2", at=1.2, clock=12, off_wall=0.05) == pytest.approx([2.5, -1.7, 0.1])
    # Downstream is -y: the right is -x.
    assert place(part="straight 2", at=1.2, clock=3, off_wall=0.05) == pytest.approx([2.4, -1.7, 0.0])


def test_half_way_through_a_bend_a_place_lies_on_its_arc():
    half = 0.5 * np.sin(np.pi / 4)
    assert place(part="bend 1", at=0.5 * np.pi / 4) == pytest.approx([2 + half, half - 0.5, 0.0], abs=1e-5)


@given(
    part=st.sampled_from(["straight 1", "bend 1", "straight 2"]),
    at=st.floats(0.01, 0.7),
    clock=st.floats(0, 12),
    off_wall=st.floats(0, 0.15),
)
def test_a_place_lies_in_its_part_as_far_off_the_wall_as_it_says(part, at, clock, off_wall):
    point = np.array(place(part=part, at=at, clock=clock, off_wall=off_wall))
    centre = np.array(place(part=part, at=at))
    assert np.linalg.norm(point - centre) == pytest.approx(0.15 - off_wall, abs=1e-9)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"part": "strait 2"}, "did you mean 'straight 2'"),
        ({"part": "straight 1", "at": 2.5}, "beyond the end of 'straight 1', which is 2 m long"),
        ({"part": "straight 1", "off_wall": 0.2}, "the bore has a radius of 0.15 m"),
        ({"part": "straight 1", "branch": True}, "has no branch"),
        ({"part": "straight 1", "clock": 13}, "clock = 13, and should be less than or equal to 12"),
        ({"part": "straight 1", "hour": 3}, "hour: Extra inputs"),
        ({"at": 1.0}, "needs 'part'"),
    ],
)
def test_what_is_no_place_is_refused_with_the_value(values, message):
    with pytest.raises(ValueError, match=message):
        resolve_place(values, BENT)


def test_a_study_may_name_its_targets_by_places():
    place = 'targets.TP1={part = "straight 1", at = 4.5, clock = 12, off_wall = 0.4}'
    study = load_study("pipe-inspection", [place], targets=["TP1"], run={"seed": 0})
    assert study.scenario.target_points()["TP1"] == pytest.approx((4.5, 0.0, 0.6))


@pytest.mark.parametrize(
    ("target", "distance", "nearest"),
    [
        ("[1.0,0.0,-1.3]", "0.3", "0.99, 0, -1"),
        ("[-0.8,0.0,0.2]", "0.8", "0, 0, 0.2"),
        ("[9.3,0.0,1.4]", "0.5", "9, 0, 1"),
    ],
    ids=["beside", "upstream", "beyond the corner"],
)
def test_a_target_outside_names_its_distance_and_the_nearest_point_inside(target, distance, nearest):
    with pytest.raises(InputError) as error:
        load_study("pipe-inspection", [f"targets.TP1={target}", "targets.TP2=[99,0,0]"], run={"seed": 0})
    assert "--set targets.TP2=[99,0,0]: targets.TP2 = [99.0, 0.0, 0.0] lies outside" in str(error.value)
    assert f"lies outside the pipe, {distance} m from it; the nearest point inside is [{nearest}]" in str(error.value)


@given(st.floats(-0.2, 0.2), st.floats(0.3, 1.5), st.floats(0, 6.28))
def test_the_nearest_point_inside_is_on_the_way_to_the_axis(x, away, turn):
    point = np.array([1 + x, away * np.cos(turn), away * np.sin(turn)])
    nearest, distance = find_nearest_inside(point, BENT)
    if np.cos(turn) > 0 and np.hypot(*point[1:]) < 1.0:
        assert distance == pytest.approx(away - 0.15, rel=0.01)
        assert np.linalg.norm(nearest - point) == pytest.approx(distance, rel=0.01)


@pytest.mark.parametrize("slope", [0.0, 30.0])
@pytest.mark.parametrize("frame", ["inlet", "world"])
def test_a_release_may_be_given_as_a_place(frame, slope):
    direction = [float(np.cos(np.deg2rad(slope))), 0.0, float(-np.sin(np.deg2rad(slope)))]
    pipe = f"pipe={{segments = [], radius = 0.5, start = [1.0, 2.0, 3.0], direction = {direction}, parts = [{{kind = 'straight', length = 4.0}}]}}"
    spot = "release.position={part = 'straight 1', at = 1.0, clock = 12, off_wall = 0.1}"
    scenario = load_study("pipe-inspection", [pipe, "targets={}", spot, f"release.frame='{frame}'"]).scenario
    up = np.array([np.sin(np.deg2rad(slope)), 0.0, np.cos(np.deg2rad(slope))])
    assert scenario.release_position() == pytest.approx([1.0, 2.0, 3.0] + np.array(direction) + 0.4 * up)


def test_a_release_at_a_place_that_there_is_not_names_its_key():
    spot = "release.position={part = 'straight 2', at = 1.0}"
    with pytest.raises(InputError, match=r"release\.position: no part is called 'straight 2'"):
        load_study("pipe-inspection", [spot])
