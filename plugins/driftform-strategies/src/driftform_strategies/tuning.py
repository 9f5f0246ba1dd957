"""The secant of tuning: which ballast makes a body pass a target, from the flights with other ballast.

In a straight pipe the paths of agents form one family in their net weight W. The height at which a body passes a target is
nearly linear in sign(W) |W|^1/2, which is proportional to the speed at which it sinks: the drag is quadratic. So the
secant is taken in that variable, here in kg^1/2.
"""

from collections.abc import Sequence
from math import copysign, nan, prod, sqrt

MIN_SLOPE = 0.02
"""Least response, over the expected one, of a body that is tuned: a body that rides the wall has less."""

FARTHEST = 3.0
"""Most times the distance between two flights that the next one may lie beyond them."""


def root_weight(weight: float) -> float:
    """Return sign(W) |W|^1/2 of a net weight (kg)."""
    return copysign(sqrt(abs(weight)), weight)


def square_root_weight(root: float) -> float:
    """Return the net weight (kg) of which :func:`root_weight` is ``root``."""
    return copysign(root * root, root)


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
