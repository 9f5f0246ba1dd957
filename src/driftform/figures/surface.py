"""Rest position of a body in the water of a scenario, in words and as a line across its section."""

import math
from dataclasses import dataclass

import numpy as np

from driftform.figures.bodies import Placement
from driftform.types import Agent, Body, FloatArray
from driftform.water import Scenario

_NO_LEVER = 1e-6
"""m: if the centres of gravity and buoyancy are nearer than this, the body has no preferred attitude."""

_STRAIGHT = np.deg2rad(3.0)
"""rad: an attitude within this of upright or level is called so."""


@dataclass(frozen=True)
class WaterRest:
    """A body at rest, far from any wall.

    Attributes:
        text: description of the rest position.
        pitch: of the axis, rad, positive nose down.
        height: of the body's origin above the surface, m; ``None`` if it does not float.
    """

    text: str
    pitch: float
    height: float | None


@dataclass(frozen=True, eq=False)
class Surface:
    """The water's surface on the page, px.

    Attributes:
        line: both ends, (2, 2).
        wet: corners of the polygon of water, (n, 2).
        up: unit vector out of the water, (2,).
    """

    line: FloatArray
    wet: FloatArray
    up: FloatArray

    def find_mark(self) -> FloatArray:
        """Return the corners of the symbol of a water line, a triangle, (3, 2)."""
        (start, end), up = self.line, self.up
        # Keep off the labels: those of the centres are above the body, that of the axis is on the right.
        tip = max(start, end, key=lambda point: float(point[1] - point[0]))
        inward = (start + end) / 2 - tip
        tip = tip + 9 * inward / max(float(np.hypot(*inward)), 1e-9)
        along = np.array([-up[1], up[0]])
        return np.array([tip, tip + 8 * up + 5 * along, tip + 8 * up - 5 * along])


def find_rest(agent: Agent, scenario: Scenario) -> WaterRest | None:
    """Return the agent's rest position in the scenario's water; ``None`` without gravity.

    If the scenario has no free surface, a body that rises is shown as it would float at one.
    """
    from driftform.motion.forces.model import flight_model
    from driftform.motion.path.stability import stable_rest

    fluid, mass = scenario.fluid, agent.mass
    if not fluid.gravity:
        return None
    open_water = scenario.model_copy(update={"fluid": fluid.model_copy(update={"water_level": 0.0})})
    rest = stable_rest(flight_model(agent, open_water))
    attitude = _describe_attitude(rest.pitch)
    if rest.height is None:
        lever = abs(float(mass.cob[0] - mass.cog[0]))
        attitude = attitude if lever > _NO_LEVER else "in any attitude"
        return WaterRest(f"Sinks and hangs {attitude}.", rest.pitch, None)
    share = mass.mass / (fluid.density * mass.volume)
    floats = "Water line: floats" if fluid.water_level is not None else "Rises; at a surface it would float"
    text = f"{floats} {attitude}, {100 * share:.0f} % under water."
    return WaterRest(text, rest.pitch, rest.height)


def _describe_attitude(pitch: float) -> str:
    nose = "nose down" if pitch > 0 else "nose up"
    if abs(pitch) < _STRAIGHT:
        return "level"
    if math.pi / 2 - abs(pitch) < _STRAIGHT:
        return f"upright, {nose}"
    return f"{nose} by {abs(math.degrees(pitch)):.0f}°"


def find_surface(pitch: float, height: float, body: Body, place: Placement, around: float) -> Surface | None:
    """Return the surface across a body at rest, its pitch in rad and its origin ``height`` (m) above the water.

    Water is drawn up to ``around`` px around the body. Return ``None`` if the surface does not cross that region.
    """
    # A point (x, z) of the body is height - x sin(pitch) + z cos(pitch) above the surface.
    normal = np.array([-math.sin(pitch), math.cos(pitch)])
    pad = around / place.px_per_m
    low = np.array([body.outer[0, 0] - pad, -body.max_diameter / 2 - pad])
    high = np.array([body.outer[-1, 0] + pad, body.max_diameter / 2 + pad])
    box = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    above = height + box @ normal
    wet: list[FloatArray] = []
    crossings: list[FloatArray] = []
    for a, b, at_a, at_b in zip(box, np.roll(box, -1, axis=0), above, np.roll(above, -1), strict=True):
        if at_a <= 0:
            wet.append(a)
        if (at_a <= 0) != (at_b <= 0):
            crossings.append(a + (b - a) * at_a / (at_a - at_b))
            wet.append(crossings[-1])
    if len(crossings) != 2:
        return None
    up = normal * (1.0, -1.0)
    return Surface(place.to_page(np.array(crossings)), place.to_page(np.array(wet)), up)
