"""Heavy spheres that roll along a pipe

Source: H. S. Ellis, The pipeline flow of capsules, part 5: an experimental investigation of the transport by water of single
spherical capsules with density greater than that of the water, Canadian Journal of Chemical Engineering 42 (1964), from the
abstract: in a pipe of 1 1/4 inches and above 2 feet per second, spheres of more than half of the bore were carried at 1.04
to 1.08 times the mean velocity of the water, mostly rolling.

Driftform: spheres of 2.7 times the density of the water, released at rest on the floor, in the logarithmic law of a smooth
pipe, with friction 0.3 and `drag = "strips"`; the velocity in the last of 6 s.

Left out: the flow through the gap, which differs above and below a sphere on the floor. The drag of a body that fills much of
the bore is increased as measured on the axis of a tube.

Met: 0.69 of the bore, and rolling. Not met: 0.5 of the bore, by 0.02 to 0.03; both are out of range.
"""

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
