"""Heavy spheres that roll along a pipe."""

import numpy as np
from rolling import BORE, FOOT, carry_along_floor, last_speed

from driftform.testing.bodies import spheroid_body


def measure():
    """Return rows of what is compared, measured and found."""
    rows = []
    for ratio in (0.5, 0.69):
        radius = ratio * BORE / 2
        for feet in (2.5, 5.0):
            flight = carry_along_floor(spheroid_body(radius, radius, edges=100), 2.7, feet * FOOT, BORE, 6.0)
            along = last_speed(flight, 1 / 6)
            rows.append((f"d/D {ratio}, {feet} ft/s: velocity over the water's", "1.04 to 1.08", along / (feet * FOOT)))
        rolling = float(np.linalg.norm(flight.velocity[-1, 3:])) * radius / along
        rows.append((f"d/D {ratio}: surface's speed over rolling", "mostly rolling", rolling))
    return rows
