"""Warnings of agents that are outside of what was tested."""

from dataclasses import replace

import numpy as np
import pytest
from solids import solid_agent

from driftform.motion.body_drag import estimate_drag
from driftform.study.limits import list_limits
from driftform.testing.bodies import cylinder_body, spheroid_body
from driftform.types import Coefficients
from driftform.water import Fluid, Pipe, Scenario, Segment

FLUID = Fluid(density=1000.0, viscosity=1e-6)


def scenario_of(radius):
    return Scenario(
        fluid=FLUID, pipe=Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=radius),))
    )


def agent_of(body, density):

    drag = estimate_drag(body, FLUID.viscosity)
    return solid_agent(body, density, Coefficients(0.01 * np.eye(6), drag=drag))


SPHERE, CYLINDER = spheroid_body(0.02, 0.02, edges=60), cylinder_body(0.1, 0.01)


def test_an_ordinary_agent_is_within_what_was_tested():
    assert list_limits(agent_of(CYLINDER, 1010.0), scenario_of(1.0)) == []
    assert list_limits(agent_of(SPHERE, 990.0), scenario_of(1.0)) == []


def test_a_light_sphere_zigzags_and_a_light_cylinder_is_another_matter():
    (line,) = list_limits(agent_of(SPHERE, 500.0), scenario_of(1.0))
    assert "0.50 times as dense" in line and "zigzags" in line
    assert list_limits(agent_of(CYLINDER, 500.0), scenario_of(1.0)) == []


@pytest.mark.parametrize(("radius", "outside"), [(0.034, False), (0.033, True)])
def test_a_body_that_fills_a_third_of_its_pipe_is_outside(radius, outside):
    lines = list_limits(agent_of(CYLINDER, 1010.0), scenario_of(radius))
    assert len(lines) == outside
    assert not outside or ("30 % of the pipe's" in lines[0] and "up to 30 %" in lines[0])


def test_a_body_that_sinks_into_the_drag_crisis_is_outside():
    (line,) = list_limits(agent_of(spheroid_body(0.1, 0.1, edges=60), 8000.0), scenario_of(1.0))
    assert line.startswith("it sinks at a Reynolds number of up to") and "2e+05" in line


def test_the_reynolds_number_is_that_of_an_agent_that_flies_with_drag():
    agent = agent_of(spheroid_body(0.1, 0.1, edges=60), 8000.0)
    ideal = replace(agent, coefficients=replace(agent.coefficients, drag=None))
    assert list_limits(ideal, scenario_of(1.0)) == []
