"""The water of a tee between its ends, and the space of the ball that rounds its edge."""

import math

from driftform.types import FloatArray
from driftform.util import compiled
from driftform.water.parts import tee_wall, walls


@compiled
def distance_from_ball(x: float, y: float, z: float, wall: FloatArray) -> float:
    """Return the distance of a point from the space through which the ball rolls; negative in it."""
    cx, cy, cz = walls.nearest_on_edge((x, y, z), wall, 0)
    return float(math.sqrt((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2) - wall[walls.FILLET])


@compiled
def distance_beyond_ends(x: float, y: float, z: float, wall: FloatArray) -> float:
    """Return how far a point lies beyond the nearest end, negative between the ends."""
    along = max(-wall[walls.UPSTREAM] - x, x - wall[walls.DOWNSTREAM])
    if y * y + z * z <= 1.0:
        return float(along)
    return float(max(along, x * wall[walls.COSINE] + z * wall[walls.SINE] - wall[walls.SIDE]))


@compiled
def water_level(x: float, y: float, z: float, wall: FloatArray) -> float:
    """Return a number that is negative in the water between the ends, and 0 on its boundary."""
    return max(tee_wall.wall_level(x, y, z, wall)[0], distance_beyond_ends(x, y, z, wall))
