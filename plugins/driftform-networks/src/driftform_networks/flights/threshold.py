"""Incipient motion: the speed of the water from which a body that lies on the wall of a pipe moves."""

import numpy as np

from driftform.motion import forces
from driftform.water import field
from driftform_networks.flights.bodies import Traveller


def rolling_resistance(diameter: float, roughness: float) -> float:
    """Return the force along a level wall, relative to that onto it, from which a sphere rolls over grains as high as the roughness.

    About the edge of a grain of height k, the moments of a force through the middle of a sphere of radius a, and of its net weight,
    are in balance at sqrt(a^2 - (a - k)^2) / (a - k).

    Args:
        diameter: of the sphere, m.
        roughness: k, m, from 0 to less than the radius.

    >>> [round(rolling_resistance(d, 0.0003), 3) for d in (0.06, 0.01)]
    [0.142, 0.363]
    """
    left = diameter / 2 - roughness
    return float(np.sqrt(max((diameter / 2) ** 2 - left**2, 0.0)) / left) if left > 0 else np.inf


def moving_speed(traveller: Traveller, bore: float, slope: float = 0.0) -> float:
    """Return the mean speed (m/s) of the water from which a body that lies on the wall moves; 0 if it has no weight, or the slope moves it.

    There the drag of the water at its middle, as of a body along the pipe in open water, is its net weight times the friction of the
    wall, or the :func:`rolling_resistance` of a sphere if that is less, and what pulls it back down the slope. The gap beside a body of
    the diameter b of the bore speeds the water up by 1 / (1 - b^2). Lift, tilt and gusts, which help it, are left out: flown agents
    move from half this speed on.

    Args:
        traveller: the body.
        bore: m, wider than it.
        slope: rise over length, along the flow.
    """
    scenario, agent, radius = traveller.scenario, traveller.agent, traveller.width / 2
    net, fluid, grip = agent.mass.net_buoyancy(scenario.fluid), scenario.fluid, scenario.contact.friction
    if agent.body.length < 1.001 * traveller.width:
        grip = min(grip, rolling_resistance(traveller.width, getattr(scenario.flow, "roughness", 0.0)))
    force = (abs(net) * grip - net * slope) / np.hypot(1.0, slope)
    if force <= 1e-12:
        return 0.0
    drag = agent.coefficients.drag or forces.estimate_drag(agent.body, fluid.viscosity)
    there = max(
        forces.terminal_speeds(drag, force, first, fluid.density, fluid.viscosity)[0] for first in (True, False)
    )
    speed = there * (1 - (traveller.width / bore) ** 2)
    calm = {"gusts": scenario.gusts.model_copy(update={"strength": 0.0})}
    middle, wanted = [[0.5, 0.0, radius - bore / 2]], speed
    for _ in range(4):
        # The profile changes little with the speed.
        placed = traveller.place(bore, speed).model_copy(update=calm)
        found = float(field.water_velocity(middle, 0.0, placed)[0, 0])
        speed *= wanted / max(found, 0.1 * speed)
    return float(speed)
