"""Rest position of a body in the water of a scenario, in words."""

import math

import numpy as np

from driftform.types import Agent
from driftform.water import Scenario

_NO_LEVER = 1e-6
"""m: if the centres of gravity and buoyancy are nearer than this, the body has no preferred attitude."""

_STRAIGHT = np.deg2rad(3.0)
"""rad: an attitude within this of upright or level is called so."""


def describe_rest(agent: Agent, scenario: Scenario) -> str:
    """Return the agent's rest position in the scenario's water, far from any wall, in words; nothing without gravity.

    If the scenario has no free surface, a body that rises is described as it would float at one.
    """
    from driftform.motion.forces.model import flight_model
    from driftform.motion.path.stability import stable_rest

    fluid, mass = scenario.fluid, agent.mass
    if not fluid.gravity:
        return ""
    open_water = scenario.model_copy(update={"fluid": fluid.model_copy(update={"water_level": 0.0})})
    rest = stable_rest(flight_model(agent, open_water))
    attitude = _describe_attitude(rest.pitch)
    if rest.height is None:
        lever = abs(float(mass.cob[0] - mass.cog[0]))
        attitude = attitude if lever > _NO_LEVER else "in any attitude"
        return f"Sinks and hangs {attitude}."
    share = mass.mass / (fluid.density * mass.volume)
    floats = "Floats" if fluid.water_level is not None else "Rises; at a surface it would float"
    return f"{floats} {attitude}, {100 * share:.0f} % under water."


def _describe_attitude(pitch: float) -> str:
    nose = "nose down" if pitch > 0 else "nose up"
    if abs(pitch) < _STRAIGHT:
        return "level"
    if math.pi / 2 - abs(pitch) < _STRAIGHT:
        return f"upright, {nose}"
    return f"{nose} by {abs(math.degrees(pitch)):.0f}°"
