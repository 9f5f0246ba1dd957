"""The water of a tee between its ends, and the space of the ball that rounds its edge."""

import math

from driftform.types import FloatArray
from driftform.util import compiled
from driftform.water.parts import tee_wall


@compiled
def distance_from_ball(x: float, y: float, z: float, wall: FloatArray) -> float:
    """Return the distance of a point from the space through which the ball rolls; negative in it."""
    cx, cy, cz = tee_wall.nearest_on_edge((x, y, z), wall, 0)
    return float(math.sqrt((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2) - wall[tee_wall.FILLET])


@compiled
def distance_beyond_ends(x: float, y: float, z: float, wall: FloatArray) -> float:
    """Return how far a point lies beyond the nearest end, negative between the ends."""
    along = max(-wall[tee_wall.UPSTREAM] - x, x - wall[tee_wall.DOWNSTREAM])
    if y * y + z * z <= 1.0:
        return float(along)
    return float(max(along, x * wall[tee_wall.COSINE] + z * wall[tee_wall.SINE] - wall[tee_wall.SIDE]))


@compiled
def water_level(x: float, y: float, z: float, wall: FloatArray) -> float:
    """Return a number that is negative in the water between the ends, and 0 on its boundary."""
    return max(tee_wall.wall_level(x, y, z, wall)[0], distance_beyond_ends(x, y, z, wall))
