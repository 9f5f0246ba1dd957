"""The fitness of outlets: full marks for the right one, and a slope towards it."""

from itertools import pairwise

import numpy as np
import pytest

from driftform.builtin.fitness import PASSED_BY, OutletFitness
from driftform.motion.path.targets import farthest_distances
from driftform.testing import FitnessContract
from driftform.testing.agents import sphere_agent
from driftform.types import End, Trajectory, Verdict
from driftform.util.options import Table
from driftform.water import Scenario

TEE = {"kind": "tee", "branch_radius": 0.05, "share": 0.3, "branch": [{"length": 0.5, "outlet": "up"}]}
PARTS = [{"length": 1.0}, TEE, {"length": 1.0, "outlet": "on"}]


class TestOutletFitness(FitnessContract):
    """In a straight pipe, whose targets are points, it scores as closest-approach."""

    rewards_closeness = True

    def plugin(self) -> OutletFitness:
        return OutletFitness(Table())


def scenario(**targets):
    return Scenario.model_validate({"pipe": {"radius": 0.1, "parts": PARTS}, "targets": targets})


def flight(*points, end=End.OUTLET):
    points = [np.array(p, dtype=float) for p in points]
    positions = np.concatenate([np.linspace(a, b, 60)[:-1] for a, b in pairwise(points)] + [points[-1:]])
    t = 0.02 * np.arange(len(positions))
    velocity = np.zeros((len(t), 6))
    velocity[:, :3] = np.gradient(positions, t, axis=0)
    return Trajectory(t, positions, np.tile([1.0, 0, 0, 0], (len(t), 1)), velocity, end)


def score(path, **targets):
    return OutletFitness(Table()).score(path, scenario(**targets), sphere_agent(0.01, 0.01))


def place_tee():
    layout = scenario().pipe.layout
    return layout.parts[1].part.origin, {o.name: o.opening.centre for o in layout.outlets}


def test_a_flight_that_leaves_by_an_outlet_has_all_of_it_and_little_of_the_other():
    tee, outlets = place_tee()
    up, on = score(flight((0, 0, 0), tee, outlets["up"]), A="up", B="on")
    assert up == 100 and 0 < on < PASSED_BY
    up, on = score(flight((0, 0, 0), tee, outlets["on"]), A="up", B="on")
    assert on == 100 and 0 < up < PASSED_BY


def test_a_flight_that_stops_before_its_outlet_has_not_left_there():
    tee, outlets = place_tee()
    stopped = flight((0, 0, 0), tee, outlets["up"] - [0, 0, 1e-4], end=End.HORIZON)
    [value] = score(stopped, A="up")
    assert value < PASSED_BY
    assert OutletFitness(Table()).judge(value) is Verdict.MISSED


def test_passing_closer_to_the_branch_is_worth_more():
    tee, outlets = place_tee()
    heights = (-0.08, -0.03, 0.0, 0.05, 0.09)
    values = [
        score(flight((0, 0, z), np.add(tee, [0, 0, z]), np.add(outlets["on"], [0, 0, z])), A="up")[0] for z in heights
    ]
    assert (np.diff(values) > 0).all()
    # The way from the axis of the junction to the outlet is straight: the distance through the water has a closed form.
    way = np.linalg.norm(outlets["up"] - tee)
    farthest = farthest_distances(scenario(A="up"))[0]
    assert values[2] == pytest.approx(PASSED_BY * (1 - way / farthest), rel=0.02)


def test_a_target_that_is_a_point_counts_by_its_closest_approach():
    tee, outlets = place_tee()
    x, y, z = tee.tolist()
    outlet, point = score(flight((0, 0, 0), tee, outlets["on"]), A="on", P=[x, y, z])
    assert outlet == 100 and point == pytest.approx(100, abs=1e-6)
