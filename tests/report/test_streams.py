"""Paths of the water in pipes with parts, along which the arrows of a page drift."""

import numpy as np
import pytest

from driftform.figures.streams import simplify_motion, spread_over_disc, trace_streams
from driftform.water import Pipe, Scenario
from driftform.water.flow import UniformFlow

RUN = {"kind": "straight", "length": 1.0}
SHARE = 0.4


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    """A bend and a tee, in plug flow."""
    branch = [{"kind": "straight", "length": 0.5, "outlet": "side"}]
    tee = {"kind": "tee", "branch_radius": 0.1, "share": SHARE, "branch": branch}
    end = {"kind": "straight", "length": 0.5, "outlet": "run"}
    pipe = Pipe(radius=0.1, parts=(RUN, {"kind": "bend", "radius": 0.3}, tee, end))
    return Scenario(pipe=pipe, targets={}, flow=UniformFlow(speed=0.5))


@pytest.mark.parametrize("name", ["side", "run"])
def test_the_water_divides_among_the_outlets_in_the_shares_of_the_flow(scenario, name):
    outlets = {outlet.name: outlet.opening for outlet in scenario.pipe.layout.outlets}
    paths = trace_streams(scenario)
    ends = np.array([path[-1, 1:] for path in paths])
    opening = outlets[name]
    off = ends - opening.centre
    here = (np.abs(off @ opening.axes[0]) < 0.05) & (np.linalg.norm(off, axis=1) < 0.15)
    # Each path begins in the same area of plug flow, so it stands for the same flow; the middle of an area may go either way.
    expected = SHARE if name == "side" else 1 - SHARE
    assert np.count_nonzero(here) == pytest.approx(expected * len(paths), abs=2.5)


def test_paths_stay_in_the_pipe_and_keep_its_mean_speed_in_straights(scenario):
    layout = scenario.pipe.layout
    for path in trace_streams(scenario):
        assert (layout.find_part(path[:-1, 1:]) >= 0).all()
        assert (np.diff(path[:, 0]) > 0).all()
        # From the inlet to where the bend begins to turn the flow.
        x = np.interp(1.0, path[:, 0], path[:, 1])
        assert x == pytest.approx(0.5, abs=0.01)


def test_a_straight_pipe_has_no_paths_because_its_profile_is_known():
    assert trace_streams(Scenario()) == []


def test_a_tee_whose_flow_is_not_solved_yet_has_no_paths_rather_than_a_wait(scenario, tmp_path, monkeypatch):
    monkeypatch.setenv("DRIFTFORM_CACHE", str(tmp_path))
    run, bend, tee, end = scenario.pipe.parts
    odd = Pipe(radius=0.1, parts=(run, bend, tee.model_copy(update={"branch_radius": 0.0613}), end))
    assert trace_streams(scenario.model_copy(update={"pipe": odd})) == []
    assert not list(tmp_path.iterdir())


def test_a_motion_without_its_needless_points_is_never_farther_off_than_the_tolerance():
    t = np.linspace(0, 5, 400)
    path = np.column_stack([t, np.sin(t), np.cos(t), t**2])
    fewer = simplify_motion(path, 0.01)
    again = np.column_stack([np.interp(t, fewer[:, 0], fewer[:, k]) for k in (1, 2, 3)])
    assert np.linalg.norm(again - path[:, 1:], axis=1).max() <= 0.01
    assert len(fewer) < 80
    # A steady motion needs no point between its ends, although its points are as dense; a change of speed on a line does.
    assert len(simplify_motion(np.column_stack([t, t, 0 * t, 0 * t]), 1e-9)) == 2
    assert len(simplify_motion(np.column_stack([t, t**2, 0 * t, 0 * t]), 0.01)) > 10


def test_the_beginnings_of_paths_stand_for_equal_areas():
    radii = np.linalg.norm(spread_over_disc(400), axis=1)
    # Within the radius r lie r^2 of all areas.
    for r in (0.25, 0.5, 0.75):
        assert np.count_nonzero(radii < r) == pytest.approx(400 * r**2, abs=1)
