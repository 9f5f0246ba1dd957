"""Where an agent is outside of the ranges of the formulas that fly it: :mod:`driftform.util.validity`."""

from driftform.motion.forces.body_drag import SLENDER
from driftform.motion.forces.drag_coefficients import sphericity
from driftform.motion.forces.terminal import terminal_speeds
from driftform.types import Agent
from driftform.util.validity import find_departures
from driftform.water import Scenario

SLIP = 0.2
"""Speed through the water, over that of the water, that any agent may reach: in a gust, at a wall, in a bend."""

CREEPING = 1.0
"""Reynolds number (on the diameter) below which a body counts as creeping."""


def list_limits(agent: Agent, scenario: Scenario) -> list[str]:
    """Return one line for each range that an agent in a scenario is outside of.

    Its speed through the water is the greater of its terminal speeds, or :data:`SLIP` of the current; without drag it has none.
    """
    body, mass, fluid = agent.body, agent.mass, scenario.fluid
    values = {"L/d": body.length / body.max_diameter}
    if not scenario.pipe.is_open:
        values["b"] = 0.5 * body.max_diameter / scenario.pipe.layout.narrowest
    if fluid.water_level is not None:
        values["h/d"] = abs(fluid.water_level - scenario.release_position()[2]) / body.max_diameter
    if sphericity(body.outer) > SLENDER:
        values["rho_b/rho"] = mass.mass / (fluid.density * mass.volume)
    formulas = ["spheres that rise straight", "a body in a bore", "added mass below a free surface"]
    drag = agent.coefficients.drag
    if drag is not None and len(drag.strips) > 0:
        net = mass.net_buoyancy(fluid)
        terminal = terminal_speeds(drag, net, net > 0, fluid.density, fluid.viscosity)
        speed = max(*terminal, SLIP * abs(scenario.flow.speed))
        values["Re_d"] = speed * body.max_diameter / fluid.viscosity
        values["Re_L"] = speed * body.length / fluid.viscosity
        formulas += ["drag", "skin friction", "no history force"]
        if values["Re_d"] < CREEPING:
            formulas.append("creeping in a bore")
    return [line for formula in formulas for line in find_departures(formula, values)]
