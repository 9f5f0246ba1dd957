"""The fitness of outlets: full marks for the right one, and a slope towards it."""

import numpy as np
import pytest
from junctions import fly_along, junction_scenario

from driftform.builtin.fitness import PASSED_BY, OutletFitness
from driftform.motion.path.targets import farthest_distances
from driftform.testing import FitnessContract
from driftform.testing.agents import sphere_agent
from driftform.types import End, Verdict
from driftform.util.options import Table


class TestOutletFitness(FitnessContract):
    """In a straight pipe, whose targets are points, it scores as closest-approach."""

    rewards_closeness = True

    def plugin(self):
        return OutletFitness(Table())


def score(path, **targets):
    return OutletFitness(Table()).score(path, junction_scenario(**targets), sphere_agent(0.01, 0.01))


def place_tee():
    layout = junction_scenario().pipe.layout
    return layout.parts[1].part.origin, {o.name: o.opening.centre for o in layout.outlets}


def test_a_flight_that_leaves_by_an_outlet_has_all_of_it_and_little_of_the_other():
    tee, outlets = place_tee()
    up, on = score(fly_along((0, 0, 0), tee, outlets["up"]), A="up", B="on")
    assert up == 100 and 0 < on < PASSED_BY
    up, on = score(fly_along((0, 0, 0), tee, outlets["on"]), A="up", B="on")
    assert on == 100 and 0 < up < PASSED_BY


def test_a_flight_that_stops_before_its_outlet_has_not_left_there():
    tee, outlets = place_tee()
    stopped = fly_along((0, 0, 0), tee, outlets["up"] - [0, 0, 1e-4], end=End.HORIZON)
    [value] = score(stopped, A="up")
    assert value < PASSED_BY
    assert OutletFitness(Table()).judge(value) is Verdict.MISSED


def test_passing_closer_to_the_branch_is_worth_more():
    tee, outlets = place_tee()
    heights = (-0.08, -0.03, 0.0, 0.05, 0.09)
    values = [
        score(fly_along((0, 0, z), np.add(tee, [0, 0, z]), np.add(outlets["on"], [0, 0, z])), A="up")[0]
        for z in heights
    ]
    assert (np.diff(values) > 0).all()
    # The way from the axis of the junction to the outlet is straight: the distance through the water has a closed form.
    way = np.linalg.norm(outlets["up"] - tee)
    farthest = farthest_distances(junction_scenario(A="up"))[0]
    assert values[2] == pytest.approx(PASSED_BY * (1 - way / farthest), rel=0.02)


def test_a_target_that_is_a_point_counts_by_its_closest_approach():
    tee, outlets = place_tee()
    x, y, z = tee.tolist()
    outlet, point = score(fly_along((0, 0, 0), tee, outlets["on"]), A="on", P=[x, y, z])
    assert outlet == 100 and point == pytest.approx(100, abs=1e-6)
