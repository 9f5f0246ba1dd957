"""Distances through the water of a pipe with parts, and the outlet by which a flight leaves."""

import numpy as np
import pytest
from junctions import fly_along, junction_scenario

from driftform.motion.path.approach import closest_approach
from driftform.motion.path.targets import (
    approach_targets,
    farthest_distances,
    find_offsets,
    find_target_approaches,
    find_within,
    name_outlet,
)
from driftform.study import load_study
from driftform.testing.fitness import straight_trajectory
from driftform.types import End, Evaluation, Genome, Trajectory
from driftform.water import Scenario
from driftform.water.scenario import Robustness


def places():
    """Where the branch begins, the junction, and the last points of run and branch."""
    layout = junction_scenario().pipe.layout
    [tee] = [placed.part for placed in layout.parts if placed.name == "T"]
    return tee.origin, tee.list_exits(), {outlet.name: outlet.opening.centre for outlet in layout.outlets}


def test_in_a_straight_pipe_the_distance_is_the_straight_one():
    plain = Scenario.model_validate(
        {
            "pipe": {"segments": [{"start": [0, 0, 0], "end": [9, 0, 0], "radius": 1.0}]},
            "targets": {"A": [1.0, 0.0, 0.5], "B": [7.0, 0.3, 0.0]},
        }
    )
    path = straight_trajectory((0, 0, 0), (9, 0, 0.9), np.linspace(0, 9, 30))
    expected = closest_approach(path, plain.target_array())
    found = approach_targets(path, plain)
    assert [a.tolist() for a in found] == [a.tolist() for a in expected]


def test_a_flight_past_a_branch_is_as_far_from_its_outlet_as_the_water_is():
    junction, (_, branch), outlets = places()
    target = junction_scenario(out="up")
    # The run passes under the branch: its way leads from the part next to the tee back to the tee's end, and on.
    path = fly_along((0, 0, 0), outlets["on"])
    [distance], [t] = approach_targets(path, target)
    # Nearest is the tee itself: from the point under the branch to its mouth, and straight up from there through two straights.
    assert distance == pytest.approx(np.linalg.norm(branch.centre - junction) + 1.0, abs=1e-9)
    assert t == pytest.approx(junction[0], abs=1e-3)
    # Past the tee the way leads back through it: an offset points straight away from the target, and is as long as the way.
    beyond = fly_along((2.2, 0, 0), outlets["on"])
    [offset], [[distance], _] = (
        find_offsets(Evaluation(Genome("none", ()), np.zeros(1), beyond), target),
        approach_targets(beyond, target),
    )
    straight = beyond.position[0] - outlets["up"]
    assert distance > 1.05 * np.linalg.norm(straight)
    assert offset == pytest.approx(distance * straight / np.linalg.norm(straight), rel=1e-6)


def test_the_distance_shrinks_along_the_way_to_a_target():
    junction, _, outlets = places()
    target = junction_scenario(out="up")
    way = fly_along((0, 0, 0), junction, outlets["up"])
    shares = np.linspace(0.05, 1, 20)
    distances = []
    for share in shares:
        k = max(2, int(share * len(way.t)))
        part = Trajectory(way.t[:k], way.position[:k], way.quaternion[:k], way.velocity[:k], End.HORIZON)
        distances.append(approach_targets(part, target)[0][0])
    assert (np.diff(distances) < 0).all()
    assert distances[-1] == pytest.approx(0.0, abs=1e-9)


def test_a_target_in_the_next_part_is_as_far_as_the_straight_line():
    target = junction_scenario(near=(0.9, 0.05, 0.0))
    path = fly_along((0, 0, 0), (0.8, 0, 0))
    found = find_target_approaches(path, target)
    assert found[0].distance == pytest.approx(np.hypot(0.1, 0.05), abs=1e-9)
    assert found[0].position == pytest.approx([0.8, 0, 0])


def test_the_farthest_point_is_at_the_end_of_the_longest_way():
    junction, (run, branch), _ = places()
    [farthest] = farthest_distances(junction_scenario(far="up"))
    # From the rim of the far end of the run, back to the tee, and up: the last straight begins half a metre below its outlet.
    back = np.linalg.norm(run.centre - junction)
    side = np.linalg.norm(branch.centre - junction)
    expected = np.hypot(1.0, 0.1) + 0.5 + back + side + 0.5 + 0.5
    assert farthest == pytest.approx(expected, rel=1e-3)


def test_the_outlet_is_that_in_whose_opening_the_flight_ends():
    _, _, outlets = places()
    for name, centre in outlets.items():
        edge = centre + np.array([0.0, 0.03, 0.0])
        assert name_outlet(fly_along((0, 0, 0), edge), junction_scenario()) == name
    assert name_outlet(fly_along((0, 0, 0), (0.5, 0, 0), end=End.HORIZON), junction_scenario()) is None


def test_a_flight_at_the_rim_of_a_wide_outlet_left_by_it_although_the_centre_of_a_narrow_one_is_nearer():
    branch = [{"kind": "bend", "radius": 0.03, "roll_deg": 180}, {"length": 0.394, "outlet": "narrow"}]
    tee = {"kind": "tee", "roll_deg": 0, "branch_radius": 0.02, "share": 0.05, "branch": branch}
    beside = Scenario.model_validate({"pipe": {"radius": 0.1, "parts": [tee, {"length": 0.2, "outlet": "wide"}]}})
    narrow, wide = (outlet.opening.centre for outlet in beside.pipe.layout.outlets)
    rim = wide + np.array([0.0, 0.0, 0.095])
    assert np.linalg.norm(rim - narrow) < np.linalg.norm(rim - wide)
    assert name_outlet(fly_along((0, 0, 0), rim), beside) == "wide"


def test_near_enough_is_the_papers_share_and_at_most_half_the_radius_of_the_bore_at_the_target():
    wide = load_study("pipe-inspection").scenario
    assert find_within(wide) == pytest.approx(0.05 * farthest_distances(wide))
    segment = {"start": (0, 0, 0), "end": (9, 0, 0), "radius": 0.15}
    targets = {"near": (1.0, 0.0, 0.05), "far": (8.0, 0.0, 0.0)}
    narrow = Scenario.model_validate({"pipe": {"segments": (segment,)}, "targets": targets})
    assert find_within(narrow).tolist() == [0.075, 0.075]
    given = narrow.model_copy(update={"robustness": Robustness(within={"far": 0.2})})
    assert find_within(given).tolist() == [0.075, 0.2]


def test_near_enough_in_a_branch_goes_by_the_bore_of_the_branch():
    there = junction_scenario(run=(0.5, 0.0, 0.05), branch=(1.25, 0.0, 0.9))
    assert find_within(there) == pytest.approx([0.5 * 0.1, 0.5 * 0.05])
