"""Terminal speed: the speed at which the drag of a body equals its net weight."""

import numpy as np

from driftform.motion.forces.drag import axial_drag, creeping_drag, sphere_drag, strip_drag
from driftform.types import Drag, FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import ZERO, Vector, add, dot, scale

_MAX_SPEED = 100.0

_AHEAD: Vector = (1.0, 0.0, 0.0)
_ASTERN: Vector = (-1.0, 0.0, 0.0)
_ACROSS: Vector = (0.0, 0.0, 1.0)


def terminal_speeds(drag: Drag, net: float, fore_first: bool, density: float, viscosity: float) -> tuple[float, float]:
    """Return the terminal speeds (m/s) along the axis and across it, in still water.

    Args:
        net: net weight or net buoyancy, N; its sign is ignored.
        fore_first: True if the body moves along its axis with its fore end first.
        density: of the water, kg/m3.
        viscosity: of the water, m2/s.
    """
    along = _balance(drag, net, _AHEAD if fore_first else _ASTERN, density, viscosity)
    return along, terminal_speed_across(drag, net, density, viscosity)


def terminal_speed_across(drag: Drag, net: float, density: float, viscosity: float) -> float:
    """Return the terminal speed (m/s) across the axis; see :func:`terminal_speeds`."""
    return _balance(drag, net, _ACROSS, density, viscosity)


def _balance(drag: Drag, net: float, direction: Vector, density: float, viscosity: float) -> float:
    axial = np.array([drag.friction_area, drag.length, drag.ahead, drag.astern])
    strips, sphere = np.array(drag.strips), (drag.round_area, drag.diameter, drag.rubbing)
    creeping = np.array(drag.creeping)
    return _balance_speed(abs(net), direction, strips, axial, sphere, creeping, density, viscosity)


@compiled
def _balance_speed(
    force: float,
    direction: Vector,
    strips: FloatArray,
    axial: FloatArray,
    sphere: tuple[float, float, float],
    creeping: FloatArray,
    density: float,
    viscosity: float,
) -> float:
    """Return the speed (m/s) in a direction of the body at which its drag in still water is ``force``, N."""
    area, diameter, rubbing = sphere
    water = (density, viscosity * rubbing * rubbing, 1.0)
    low, high = 0.0, _MAX_SPEED
    for _ in range(60):
        middle = (low + high) / 2
        moving = scale(middle, direction)
        drag = sphere_drag(moving, density, viscosity, area, diameter)
        drag = add(drag, creeping_drag(moving, ZERO, ZERO, ZERO, density * viscosity, creeping)[0])
        drag = add(drag, (axial_drag(moving[0], density, viscosity, axial), 0.0, 0.0))
        for k in range(strips.shape[0]):
            drag = add(drag, strip_drag(moving, ZERO, ZERO, 0.0, water, strips[k]))
        if -dot(drag, direction) < force:
            low = middle
        else:
            high = middle
    return (low + high) / 2
