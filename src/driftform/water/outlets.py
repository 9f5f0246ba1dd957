"""Where a body leaves the water: past an outlet of a pipe, upstream of its inlet, or beyond a grid in open water."""

from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import Vector, dot, subtract
from driftform.water.parts.grid_flow import distance_beyond
from driftform.water.parts.walls import EXIT, LENGTH, OUTSIDE, RADIUS, find_part, to_part


@compiled
def has_left_pipe(position: Vector, pipe: FloatArray, fittings: FloatArray | None = None) -> bool:
    """Return True if the body's origin is past an outlet, more than a radius upstream of the inlet, or beyond a grid."""
    if fittings is not None:
        return distance_past_outlet(position, pipe, fittings) >= 0.0 or distance_upstream(position, fittings) > 0.0
    if pipe.shape[0] == 0:
        return False
    return distance_past_outlet(position, pipe, fittings) >= 0.0 or _distance_along(position, pipe[0]) < -pipe[0, 7]


@compiled
def distance_past_outlet(position: Vector, pipe: FloatArray, fittings: FloatArray | None = None) -> float:
    """Return the distance (m) of the position past an outlet, or beyond a grid in open water; negative before it."""
    if fittings is not None:
        if fittings[0] == 1.0:
            # Only open water has a single row; a pipe has those beyond its ends too.
            return distance_beyond(position, fittings)
        o, _ = find_part(position, fittings)
        # Of a pipe with parts only whether it is past the outlet: that is all that is asked for.
        return to_part(position, fittings, o)[0] if fittings[o + EXIT] >= 0.0 else -1.0
    last = pipe[pipe.shape[0] - 1]
    return float(_distance_along(position, last) - last[6])


@compiled
def distance_upstream(position: Vector, fittings: FloatArray) -> float:
    """Return how far (m) the position lies more than a radius upstream of the inlet of a pipe with parts; not positive elsewhere."""
    o, _ = find_part(position, fittings)
    if fittings[o + EXIT] != OUTSIDE:
        return -1.0
    return float(fittings[o + LENGTH] - fittings[o + RADIUS] - to_part(position, fittings, o)[0])


@compiled
def _distance_along(position: Vector, segment: FloatArray) -> float:
    off = subtract(position, (segment[0], segment[1], segment[2]))
    return dot((segment[3], segment[4], segment[5]), off)
