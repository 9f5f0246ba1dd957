"""The secant of tuning: which ballast makes a body pass a target, from the flights with other ballast.

In a straight pipe the paths of agents form one family in their net weight W. The height at which a body passes a target is
nearly linear in sign(W) |W|^1/2, which is proportional to the speed at which it sinks: the drag is quadratic. So the
secant is taken in that variable, here in kg^1/2. After a bend, weight moves a path in another direction than down: in a riser,
across it.
"""

from collections.abc import Sequence
from math import copysign, nan, prod, sqrt

import numpy as np

from driftform.types import FloatArray
from driftform.water import Scenario
from driftform.water.parts.shapes import upright_axes

MIN_SLOPE = 0.02
"""Least response, over the expected one, of a body that is tuned: a body that rides the wall has less."""

FARTHEST = 3.0
"""Most times the distance between two flights that the next one may lie beyond them."""

MAINLY = 0.5
"""Least share of a motion that is upward or downward, for its height to measure it."""


def root_weight(weight: float) -> float:
    """Return sign(W) |W|^1/2 of a net weight (kg)."""
    return copysign(sqrt(abs(weight)), weight)


def square_root_weight(root: float) -> float:
    """Return the net weight (kg) of which :func:`root_weight` is ``root``."""
    return copysign(root * root, root)


def find_up(scenario: Scenario) -> FloatArray | None:
    """Return the direction across a straight pipe in which light bodies move, (3,); ``None`` in others, and in a vertical one."""
    along = scenario.direction()
    if scenario.pipe.straight is None or not along[:2].any():
        return None
    return np.asarray(upright_axes(along)[2])


def measure_heights(points: Sequence[tuple[float, FloatArray]], up: FloatArray | None) -> list[tuple[float, float]]:
    """Return the root of the net weight of each flight, and how far it passed above a target, m.

    Without a direction ``up``, above is against the one in which weight moved the body there, if that is not mainly down: in a
    riser; one flight alone passed on the upper side of the target, by its whole distance.

    Args:
        points: of each flight the root of its net weight, and its offset from the target, m, (3,).
        up: from :func:`find_up`.
    """
    roots, offsets = np.array([root for root, _ in points]), np.array([offset for _, offset in points])
    heights = offsets @ ((0.0, 0.0, 1.0) if up is None else up)
    lower = (roots - roots.mean()) @ offsets if len(points) > 1 else offsets[0]
    moved = float(np.linalg.norm(lower))
    if up is None and abs(lower[2]) < MAINLY * moved:
        heights = -offsets @ lower / moved if len(points) > 1 else np.copysign([moved], heights)
    return list(zip(roots.tolist(), heights.tolist(), strict=True))


def find_next(points: Sequence[tuple[float, float]], slope: float) -> float | None:
    """Return the root of the net weight of the next flight; ``None`` if the body does not respond.

    Args:
        points: of earlier flights, in their order, the root of the net weight, and the height by which they passed
            above the target, m.
        slope: expected change of the height with the root, which is negative, m / kg^1/2.
    """
    # Flights with the same weight may differ a little, by their tolerances.
    ordered = sorted(dict(points).items())
    above = [point for point in ordered if point[1] > 0]
    below = [point for point in ordered if point[1] <= 0]
    # The lightest that passes below, and the heaviest above: heavier bodies pass lower.
    if above and below and above[-1][0] < below[0][0]:
        (a, high), (b, low) = above[-1], below[0]
        misses = [abs(height) for _, height in points]
        if len(misses) > 2 and points[-1][0] in (a, b) and misses[-1] > min(misses[:-1]) / 2:
            # The path changes steeply in between: interpolation creeps along one side.
            return (a + b) / 2
        if len(ordered) > 2 and a < (curved := _interpolate_inverse(ordered)) < b:
            return curved
        at = high / (high - low)
        # Near one end, take a step that is likely to bring the other end near too.
        return a + min(max(at, 0.02), 0.98) * (b - a)
    nearest = sorted(ordered, key=lambda point: abs(point[1]))[:2]
    (a, miss), found = nearest[0], slope
    if len(nearest) > 1:
        (b, other) = nearest[1]
        found = (other - miss) / (b - a)
        if not found < MIN_SLOPE * slope:
            return None
        step = -miss / found
        return a + copysign(min(abs(step), FARTHEST * abs(b - a)), step)
    return a - miss / found


def _interpolate_inverse(points: Sequence[tuple[float, float]]) -> float:
    """Return the root by the inverse parabola through the three points of least height; NaN if two heights are equal."""
    nearest = sorted(points, key=lambda point: abs(point[1]))[:3]
    heights = [height for _, height in nearest]
    if len(set(heights)) < len(nearest):
        return nan
    return sum(
        root * prod(other / (other - height) for other in heights if other != height) for root, height in nearest
    )
