"""Paths of the mean current in pipes with parts, along which the arrows of a page drift."""

import numpy as np
import pytest

from driftform.figures.scene import list_streams
from driftform.water import Pipe, Scenario
from driftform.water.flow import UniformFlow


def test_the_current_divides_among_the_outlets_and_has_the_mean_speed_of_each_bore():
    branch = [{"kind": "straight", "length": 0.5, "outlet": "side"}]
    tee = {"kind": "tee", "branch_radius": 0.1, "share": 0.4, "branch": branch}
    parts = (
        {"kind": "straight", "length": 1.0},
        {"kind": "bend", "radius": 0.3},
        tee,
        {"length": 0.5, "outlet": "run"},
    )
    scenario = Scenario(pipe=Pipe(radius=0.1, parts=parts), targets={}, flow=UniformFlow(speed=0.5))
    outlets = {outlet.name: outlet.opening for outlet in scenario.pipe.layout.outlets}
    found = dict.fromkeys(outlets, 0)
    for path in list_streams(scenario):
        assert (scenario.pipe.layout.find_part(path[:, 1:]) >= 0).all()
        assert (np.diff(path[:, 0]) > 0).all()
        speeds = np.linalg.norm(np.diff(path[:, 1:], axis=0), axis=1) / np.diff(path[:, 0])
        [name] = [n for n, end in outlets.items() if np.linalg.norm(path[-1, 1:] - end.centre) < end.radius]
        found[name] += 1
        # The bores are equally wide.
        assert [speeds[0], speeds[-1]] == pytest.approx([0.5, 0.5 * (0.4 if name == "side" else 0.6)])
    assert found == {"side": 16, "run": 24}


def test_a_straight_pipe_has_no_paths_because_its_profile_is_known():
    assert list_streams(Scenario()) == []
