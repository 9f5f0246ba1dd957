"""The plainest body that can be made around a core: a hollow sphere, or a capsule where a sphere does not float it."""

from dataclasses import dataclass

import numpy as np

from driftform.agent.mass import mass_properties
from driftform.types import Body, FloatArray

MIN_WALL = 0.0012
"""Thinnest wall of a plain body, m: three lines of a nozzle of 0.4 mm."""

MAX_SLENDERNESS = 20.0
"""Greatest length of a capsule over its diameter that is tried."""

SPARE = 0.02
"""Share of what it displaces by which a plain body must be able to be lighter: it then has room for any net weight in use."""

_ARC, _HALVINGS = 33, 40
"""Points of the contour of each end, and steps of the bisection for the wall."""


@dataclass(frozen=True)
class PlainBody:
    """A sphere, or a capsule that is longer than wide: diameter and length in m, net weight in water in kg, positive if it sinks."""

    diameter: float
    length: float
    net_weight: float

    @property
    def kind(self) -> str:
        """What it is, in words."""
        if self.length <= self.diameter:
            return f"sphere of {1000 * self.diameter:.3g} mm"
        return f"capsule of {1000 * self.diameter:.3g} x {1000 * self.length:.3g} mm"


def make_plain_body(plain: PlainBody, like: Body, density: float) -> Body:
    """Return a plain body with the core and the material of another, whose cavity gives it its net weight in water of a density.

    Raises ValueError if no cavity that holds the core, within a wall of at least :data:`MIN_WALL`, does so.
    """
    radius, reach = plain.diameter / 2, plain.length / 2 - plain.diameter / 2
    thickest = min(radius - like.core.radius, plain.length / 2 - max(map(abs, like.core.ends)))

    def hollow(wall: float) -> Body:
        return Body(
            outer=_outline(radius, reach),
            cavity=_outline(radius - wall, reach),
            joints=np.array([-radius - reach, radius + reach]),
            core=like.core,
            wall=wall,
            hull_density=like.hull_density,
            expansion=like.expansion,
            squeeze=like.squeeze,
        )

    def excess(wall: float) -> float:
        found = mass_properties(hollow(wall))
        return found.mass - density * found.volume - plain.net_weight

    thin, thick = MIN_WALL, thickest
    if not (thin < thick and excess(thin) <= 0 <= excess(thick)):
        raise ValueError(f"no wall gives a {plain.kind} a net weight of {1000 * plain.net_weight:.3g} g with this core")
    for _ in range(_HALVINGS):
        middle = (thin + thick) / 2
        thin, thick = (middle, thick) if excess(middle) <= 0 else (thin, middle)
    return hollow(thin)


def find_size(like: Body, density: float, diameter: float) -> PlainBody | None:
    """Return the sphere of a diameter (m), or the shortest capsule, that can be neutral with the core of a body; ``None`` without any."""
    spare = SPARE * density * np.pi / 6 * diameter**3
    for length in diameter * np.arange(1.0, MAX_SLENDERNESS, 0.1):
        plain = PlainBody(diameter, float(length), 0.0)
        try:
            for net in (-spare, spare):
                make_plain_body(PlainBody(diameter, float(length), net), like, density)
        except ValueError:
            continue
        return plain
    return None


def _outline(radius: float, reach: float) -> FloatArray:
    """Return the contour of a capsule from aft to fore; ``reach`` (m) is the distance of the centres of its ends from the middle."""
    turn = np.linspace(0, np.pi / 2, _ARC)
    end = radius * np.column_stack([-np.cos(turn), np.sin(turn)])
    end[0, 1] = 0.0
    fore = end[::-1] * (-1, 1)
    shift = np.array([reach, 0.0])
    return np.vstack([end - shift, (fore if reach else fore[1:]) + shift])
