"""Where an agent is outside of what the model of the water was tested with."""

from driftform.motion.body_drag import SLENDER
from driftform.motion.drag_coefficients import sphericity
from driftform.motion.terminal import terminal_speeds
from driftform.types import Agent
from driftform.water import Scenario

ZIGZAG_BELOW = 0.6
"""Density over that of the water below which spheres rise in zigzags: 0.4 for Re from 260 to 1550, 0.6 above (Horowitz and
Williamson, J. Fluid Mech. 651, 2010)."""

WIDEST = 0.3
"""Diameter over that of the bore up to which bodies in pipes were compared with measured ones (docs/experiments.md)."""

FASTEST = 2e5
"""Reynolds number (on the diameter) from which the drag crisis is near."""


def list_limits(agent: Agent, scenario: Scenario) -> list[str]:
    """Return one line for each respect in which an agent in a scenario is outside of what was tested."""
    body, mass, fluid = agent.body, agent.mass, scenario.fluid
    lines = []
    ratio = mass.mass / (fluid.density * mass.volume)
    if sphericity(body.outer) > SLENDER and ratio < ZIGZAG_BELOW:
        lines.append(
            f"nearly a sphere, and {ratio:.2f} times as dense as the water: such bodies rise in zigzags, which no flight has"
        )
    radius = float("inf") if scenario.pipe.is_open else scenario.pipe.layout.narrowest
    filled = 0.5 * body.max_diameter / radius
    if filled > WIDEST:
        lines.append(
            f"its diameter is {100 * filled:.0f} % of the pipe's: the flow around bodies in pipes was checked up to "
            f"{100 * WIDEST:.0f} %"
        )
    drag = agent.coefficients.drag
    if drag is not None and len(drag.strips) > 0:
        net = mass.net_buoyancy(fluid)
        speed = max(terminal_speeds(drag, net, net > 0, fluid.density, fluid.viscosity))
        reynolds = speed * body.max_diameter / fluid.viscosity
        if reynolds > FASTEST:
            verb = "rises" if net > 0 else "sinks"
            lines.append(
                f"it {verb} at a Reynolds number of up to {reynolds:.1e}: drag was checked up to {FASTEST:.0e}"
            )
    return lines
