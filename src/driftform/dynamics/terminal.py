"""Terminal speed: the speed at which the drag of a body equals its net weight."""

from collections.abc import Callable

import numpy as np

from driftform.dynamics.drag import axial_drag, strip_drag
from driftform.types import Drag

_MAX_SPEED = 100.0


def terminal_speeds(
    drag: Drag, net: float, fore_first: bool, density: float, viscosity: float
) -> tuple[float, float]:
    """Return the terminal speeds (m/s) along the axis and across it, in still water.

    Parameters
    ----------
    net
        net weight or net buoyancy, N; its sign is ignored.
    fore_first
        True if the body moves along its axis with its fore end first.
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

    return _balance_speed(along, abs(net)), _balance_speed(across, abs(net))


def _balance_speed(drag: Callable[[float], float], force: float) -> float:
    low, high = 0.0, _MAX_SPEED
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if drag(middle) < force else (low, middle)
    return (low + high) / 2
