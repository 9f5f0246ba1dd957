"""Terminal speed: the speed at which the drag of a body equals its net weight."""

from collections.abc import Callable

import numpy as np

from driftform.dynamics.drag import sphere_drag, still_water_wrench, strip_drag
from driftform.dynamics.vectors import ZERO
from driftform.types import Drag, FloatArray
from driftform.util.compiled import compiled

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
    sign = 1.0 if fore_first else -1.0

    def along(speed: float) -> float:
        return float(abs(still_water_wrench(drag, (sign * speed, 0.0, 0.0), ZERO, density, viscosity)[0]))

    return _balance_speed(along, abs(net)), terminal_speed_across(drag, net, density, viscosity)


def terminal_speed_across(drag: Drag, net: float, density: float, viscosity: float) -> float:
    """Return the terminal speed (m/s) across the axis; see :func:`terminal_speeds`."""
    strips = np.array(drag.strips)

    def across(speed: float) -> float:
        return _drag_across(speed, strips, drag.round_area, drag.diameter, density, viscosity)

    return _balance_speed(across, abs(net))


@compiled
def _drag_across(
    speed: float, strips: FloatArray, round_area: float, diameter: float, density: float, viscosity: float
) -> float:
    """Return the drag (N) of a motion across the axis: that of the strips and of the sphere."""
    moving = (0.0, 0.0, speed)
    total = -sphere_drag(moving, density, viscosity, round_area, diameter)[2]
    for k in range(strips.shape[0]):
        total -= strip_drag(moving, ZERO, ZERO, 0.0, (density, viscosity, 1.0), strips[k])[2]
    return total


def _balance_speed(drag: Callable[[float], float], force: float) -> float:
    low, high = 0.0, _MAX_SPEED
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if drag(middle) < force else (low, middle)
    return (low + high) / 2
