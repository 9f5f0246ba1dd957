"""The kind of a body that won."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.search.report.kinds import name_kind
from driftform.testing.agents import sphere_agent
from driftform.types import End, Trajectory
from driftform.water import Pipe, Scenario, Segment

SCENARIO = Scenario(pipe=Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0),)))


def make_agent(length, *radii):
    agent = sphere_agent(0.01, 0.004)
    x = np.linspace(-length / 2, length / 2, len(radii))
    ends = np.array([[x[0] - 1e-6, 0.0], [x[-1] + 1e-6, 0.0]])
    outer = np.vstack([ends[:1], np.column_stack([x, radii]), ends[1:]])
    return replace(agent, body=replace(agent.body, outer=outer))


def fly(height, contact=None):
    t = np.array([0.0, 9.0])
    position = np.array([[0.0, 0.0, height], [9.0, 0.0, height]])
    turn, velocity = np.tile([1.0, 0, 0, 0], (2, 1)), np.zeros((2, 6))
    return Trajectory(t, position, turn, velocity, End.OUTLET, contact)


@pytest.mark.parametrize(
    ("agent", "flight", "kind"),
    [
        (make_agent(0.2, 0.02, 0.02, 0.02), fly(0.0), "cylinder"),
        (make_agent(0.2, 0.01, 0.03, 0.01), fly(0.0), "slender body"),
        (make_agent(0.04, 0.01, 0.03, 0.01), fly(0.0), "saucer"),
        (make_agent(0.2, 0.02, 0.02, 0.02), fly(0.98, 1.0), "crown rider"),
        (make_agent(0.2, 0.02, 0.02, 0.02), fly(-0.98, 1.0), "floor roller"),
        # It has left the wall, or touches it only later.
        (make_agent(0.2, 0.02, 0.02, 0.02), fly(0.5, 1.0), "cylinder"),
        (make_agent(0.2, 0.02, 0.02, 0.02), fly(0.98, 8.0), "cylinder"),
    ],
)
def test_a_body_is_named_by_where_it_passes_and_by_its_form(agent, flight, kind):
    assert name_kind(agent, flight, SCENARIO, 4.0) == kind
