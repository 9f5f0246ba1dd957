"""How fast a body rises or sinks where its drag carries its net weight."""

from collections.abc import Callable

import numpy as np

from driftform.dynamics.drag import axial_drag, strip_drag
from driftform.types import Drag

_FASTEST = 100.0


def terminal_speeds(
    drag: Drag, net: float, fore_first: bool, density: float, viscosity: float
) -> tuple[float, float]:
    """Return the terminal speeds (m/s) along the axis and across it, in still water.

    Parameters
    ----------
    net
        net weight or buoyancy, N, of either sign.
    fore_first
        whether it moves with its fore end first along the axis.
    density, viscosity
        of the water, kg/m3 and m2/s.
    """
    axial = np.array([drag.friction_area, drag.length, drag.ahead, drag.astern])
    sign = 1.0 if fore_first else -1.0
    rest = (0.0, 0.0, 0.0)

    def along(speed: float) -> float:
        return abs(axial_drag(sign * speed, density, viscosity, axial))

    def across(speed: float) -> float:
        fluid = (density, viscosity, 1.0)
        return sum(
            abs(strip_drag((0.0, 0.0, speed), rest, rest, 0.0, fluid, strip)[2]) for strip in drag.strips
        )

    return _balance(along, abs(net)), _balance(across, abs(net))


def _balance(drag: Callable[[float], float], force: float) -> float:
    low, high = 0.0, _FASTEST
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if drag(middle) < force else (low, middle)
    return (low + high) / 2
