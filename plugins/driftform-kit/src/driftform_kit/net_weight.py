"""What a sealed agent should weigh as it hangs under water.

The net weight decides a flight, and a scale shows it whatever the outside of the print is. Mass m and volume V of the design
weigh m - rho V in the fluid of the scenario. In a bucket of that fluid at another temperature the same agent weighs

    m - rho_b V_b,    V_b = V (1 + 3 alpha dT),

and more by what it displaces more there, since no pressure squeezes it. The volume of a print differs by some millilitres from V,
and this by a thousandth of that.
"""

from driftform.types import Agent
from driftform.water import Fluid
from driftform_kit.ballast import MATERIALS, PUTTY

ADDED = {**MATERIALS, "epoxy putty": PUTTY}
"""Densities of what can be added outside, kg/m3."""


def find_net_weight(agent: Agent, fluid: Fluid) -> float:
    """Return mass less that of the displaced fluid, kg; positive for what sinks."""
    return agent.mass.mass - fluid.density * agent.mass.volume


def find_reading(agent: Agent, fluid: Fluid, celsius: float) -> float:
    """Return the net weight (kg) that an agent of the design shows in a bucket of the fluid at a temperature, degrees C."""
    body, volume = agent.body, agent.mass.volume / (1 - agent.body.squeeze)
    warmed = volume * (1 + body.expansion * (celsius - fluid.celsius)) ** 3
    return agent.mass.mass - fluid.density_at(celsius) * warmed


def weigh_added(missing: float, fluid_density: float) -> dict[str, float]:
    """Return the mass (kg) of each of :data:`ADDED` that weighs ``missing`` (kg) under water: it displaces water too."""
    return {name: missing / (1 - fluid_density / density) for name, density in ADDED.items() if density > fluid_density}


def list_readings(
    agent: Agent, fluid: Fluid, degrees: tuple[float, ...] = (5.0, 10.0, 15.0, 20.0, 25.0)
) -> dict[float, float]:
    """Return the wanted net weight (kg) by the temperature of the bucket, degrees C."""
    return {celsius: find_reading(agent, fluid, celsius) for celsius in degrees}
