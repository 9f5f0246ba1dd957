"""Warnings of agents that are outside of what was tested."""

from dataclasses import replace

import numpy as np
import pytest
from solids import solid_agent

from driftform.motion.forces.body_drag import estimate_drag
from driftform.motion.forces.limits import list_limits
from driftform.study import load_study
from driftform.testing.agents import straight_pipe
from driftform.testing.bodies import cylinder_body, spheroid_body
from driftform.types import Coefficients
from driftform.water import Fluid, Scenario

FLUID = Fluid(density=1000.0, viscosity=1e-6)


def scenario_of(radius, fluid=FLUID):
    return Scenario(fluid=fluid, pipe=straight_pipe(9.0, radius))


def agent_of(body, density):
    drag = estimate_drag(body, FLUID.viscosity)
    return solid_agent(body, density, Coefficients(0.01 * np.eye(6), drag=drag))


SPHERE, CYLINDER = spheroid_body(0.02, 0.02, edges=60), cylinder_body(0.1, 0.01)


def test_an_ordinary_agent_is_within_what_was_tested():
    assert list_limits(agent_of(CYLINDER, 1010.0), scenario_of(1.0)) == []
    assert list_limits(agent_of(SPHERE, 990.0), scenario_of(1.0)) == []


def test_a_light_sphere_zigzags_and_a_light_cylinder_is_another_matter():
    (line,) = list_limits(agent_of(SPHERE, 500.0), scenario_of(1.0))
    assert line == (
        "spheres that rise straight: density of a body that is nearly a sphere, over that of the water rho_b/rho = 0.5; "
        "it holds from 0.6"
    )
    assert list_limits(agent_of(CYLINDER, 500.0), scenario_of(1.0)) == []


@pytest.mark.parametrize(("radius", "outside"), [(0.034, False), (0.033, True)])
def test_a_body_that_fills_a_third_of_its_pipe_is_outside(radius, outside):
    lines = list_limits(agent_of(CYLINDER, 1010.0), scenario_of(radius))
    assert len(lines) == outside
    assert not outside or "b = 0.303; it holds from 0 to 0.3" in lines[0]


def test_a_body_that_sinks_into_the_drag_crisis_is_outside():
    (line,) = list_limits(agent_of(spheroid_body(0.1, 0.1, edges=60), 8000.0), scenario_of(1.0))
    assert line.startswith("drag: Reynolds number of the body") and line.endswith("it holds from 0 to 200000")


def test_the_reynolds_number_is_that_of_an_agent_that_flies_with_drag():
    agent = agent_of(spheroid_body(0.1, 0.1, edges=60), 8000.0)
    ideal = replace(agent, coefficients=replace(agent.coefficients, drag=None))
    assert list_limits(ideal, scenario_of(1.0)) == []


def test_an_agent_in_oil_has_no_history_force_and_a_narrow_bore_slows_it_when_it_creeps():
    honey = Fluid(density=1000.0, viscosity=1e-2)
    agent = solid_agent(CYLINDER, 1010.0, Coefficients(0.01 * np.eye(6), drag=estimate_drag(CYLINDER, 1e-2)))
    history, creeping = list_limits(agent, scenario_of(0.1, honey))
    assert history.startswith("no history force: ") and "it holds from 1000" in history
    assert creeping.startswith("creeping in a bore: ") and "b = 0.1; it holds from 0 to 0.02" in creeping


def test_an_agent_near_a_free_surface_is_outside():
    agent = agent_of(CYLINDER, 1010.0)
    for level, outside in ((0.03, True), (0.05, False)):
        lines = list_limits(agent, scenario_of(1.0, FLUID.model_copy(update={"water_level": level})))
        assert len(lines) == outside
        assert not outside or "h/d = 1.5; it holds from 2" in lines[0]


@pytest.mark.parametrize("name", ["oil", "methane-60bar"])
def test_a_study_in_another_fluid_says_which_formula_does_not_hold(name):
    warnings = load_study("pipe-inspection", [f"fluid.name={name}"]).list_warnings()
    assert sum("the smallest body: " in line for line in warnings) == 1
    assert not any("it is in kg/m3" in line or "it is kinematic" in line for line in warnings)
