import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.figures.flight import flight_svg
from driftform.water import Pipe, Scenario, Segment


@settings(deadline=None, max_examples=40)
@given(
    data=st.data(),
    rise=st.floats(-0.11, 0.11),
    sideways=st.sampled_from([0.0, 0.1]),
    pitch=st.floats(-1.5, 1.5),
    title=st.text(max_size=200),
)
def test_any_body_on_any_course_keeps_to_the_page(read, fly, pipe, agents, data, rise, sideways, pitch, title):
    flight = fly(rise=rise, sideways=sideways, pitch=pitch, samples=12)
    picture = read(flight_svg(flight, pipe, title, data.draw(agents).body))
    assert picture.outside() == []


def test_targets_pipe_and_path_are_where_the_axes_say(read, points, fly, pipe):
    picture = read(flight_svg(fly(rise=-0.1), pipe))
    crosses = np.array([points(e).mean(axis=0) for e in picture.all("target")])
    assert picture.to_world(crosses) == pytest.approx(pipe.target_array()[:, [0, 2]], abs=1e-3)
    corners = picture.to_world(points(picture.one("wall")))
    assert sorted({(round(x, 2), round(z, 2)) for x, z in corners}) == [(0, -1), (0, 1), (9, -1), (9, 1)]
    path = picture.to_world(points(picture.one("path")))
    assert path[[0, -1]] == pytest.approx(np.array([[0, 0], [9, -0.9]]), abs=1e-3)


@settings(deadline=None, max_examples=40)
@given(rise=st.floats(-0.11, 0.11))
def test_the_nearest_approach_is_marked_on_the_path_where_it_is_nearest(read, points, fly, pipe, rise):
    flight = fly(rise=rise)
    picture = read(flight_svg(flight, pipe))
    mark = picture.to_world(points(picture.one("closest")).mean(axis=0, keepdims=True))[0]
    targets = pipe.target_array()
    course = np.array([1, 0, rise]) / np.hypot(1, rise)
    feet = np.minimum(targets @ course, 9 * np.hypot(1, rise))[:, None] * course
    distances = np.linalg.norm(feet - targets, axis=1)
    away = np.linalg.norm(feet[:, [0, 2]] - mark, axis=1)
    # Of two targets that are nearest alike, either will do.
    assert away[distances < distances.min() + 1e-6].min() < 2e-3
    (caption,) = (text for text in picture.texts if text.startswith("Closest to"))
    stated = re.search(r": ([\d.]+) (m|mm) away", caption)
    metres = float(stated[1]) * {"m": 1, "mm": 0.001}[stated[2]]
    assert metres == pytest.approx(distances.min(), abs=0.006)


def test_silhouettes_are_as_large_as_the_caption_says(read, points, fly, pipe, make_agent):
    body = make_agent(0.1, 0.1, [0.01, 0.02, 0.01]).body
    picture = read(flight_svg(fly(), pipe, body=body))
    assert not any(text.endswith("…") for text in picture.texts)
    (factor,) = (m[1] for text in picture.texts if (m := re.search(r"magnified (\d+) times", text)))
    assert int(factor) > 1
    for element in picture.all("silhouette"):
        size = np.ptp(picture.to_world(points(element)), axis=0)
        assert size == pytest.approx(int(factor) * np.array([0.2, 0.04]), abs=1e-3)


def test_a_body_with_its_nose_down_is_drawn_with_its_nose_down(read, points, fly, pipe, make_agent):
    body = make_agent(0.0115, 0.2, [0.012, 0.012]).body
    picture = read(flight_svg(fly(pitch=0.5), pipe, body=body))
    for element in picture.all("silhouette"):
        corners = points(element)
        assert corners[np.argmax(corners[:, 0]), 1] > corners[np.argmin(corners[:, 0]), 1]


def test_a_plan_view_is_there_only_for_a_flight_that_moves_sideways(read, fly, pipe):
    straight = read(flight_svg(fly(rise=0.05), pipe))
    sideways = read(flight_svg(fly(sideways=0.05), pipe))
    assert (len(straight.all("path")), len(sideways.all("path"))) == (1, 2)
    assert "y (m)" in sideways.texts
    assert "y (m)" not in straight.texts


@pytest.mark.parametrize("samples", [1, 2, 50])
def test_open_water_fits_the_path(read, points, fly, make_agent, samples):
    picture = read(flight_svg(fly(samples=samples), Scenario(), body=make_agent(0.1, 0.1, [0.02, 0.03]).body))
    assert picture.outside() == []
    assert picture.all("wall") == []
    start = points(picture.one("start")).mean(axis=0, keepdims=True)
    assert picture.to_world(start) == pytest.approx(np.zeros((1, 2)), abs=2e-3)


@pytest.mark.parametrize("end", [(5.0, 0.0, -3.0), (0.0, 0.0, 4.0), (3.0, 2.0, 0.0)])
def test_a_pipe_may_lie_in_any_direction(read, points, fly, end):
    segment = Segment(start=(0.0, 0.0, 0.0), end=end, radius=0.5)
    picture = read(flight_svg(fly(samples=3), Scenario(pipe=Pipe(segments=(segment,)))))
    assert picture.outside() == []
    wall, along = picture.to_world(points(picture.one("wall"))), np.array(end)[[0, 2]]
    across = 0.5 * np.array([-along[1], along[0]]) / np.linalg.norm(along)
    for corner in (across, -across, along + across, along - across):
        assert np.linalg.norm(wall - corner, axis=1).min() < 3e-3
