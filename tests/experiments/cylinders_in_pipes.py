"""Heavy cylinders that a pipe's flow carries

Source: H. S. Ellis, The pipeline flow of capsules, part 4: an experimental investigation of the transport in water of single
cylindrical capsules with density greater than that of the water, Canadian Journal of Chemical Engineering 42 (1964), from
the abstract: cylinders of 1.19 to 8.3 times the density of the water, of 0.39 to 0.89 of the bore and 2 to 14 diameters
long; above 3 feet per second the thick ones moved at up to 1.15 times the mean velocity of the water, the thicker and the
lighter the faster.

Driftform: cylinders of 1.19 times the density of the water, 4 diameters long, released at rest on the floor in the logarithmic
law at 6.6 feet per second, with `drag = "strips"` and friction 0.2, which the abstract does not state, or none; the velocity in the
last of 8 s. The gap's balance is of a long cylinder on the axis, d/D = k (H. H. van den Kroonenberg, Canadian Journal of Chemical
Engineering 57, 1979, 538): the pressure that drives water through the gap at u pushes the cylinder too, until friction balances
it. With equal friction factors V - u = u sqrt(k), and by continuity V over the mean velocity is (1 + sqrt(k)) / (1 + k^2.5).

Left out: that gap, which decides. Without friction a cylinder has the mean velocity of the undisturbed profile over its section,
whatever its drag, and friction takes 0.02 to 0.08; on a film of water, which Ellis suggests, it does not act. The balance is no
substitute: it omits the ends of a short body, and eddies as large as a thin one.

Not met, 1.07 in place of 1.15, and out of range: above 0.3 of the bore `driftform simulate`, `inspect`, `network` and the report
say so with the number.
"""

import numpy as np
from rolling import BORE, FOOT, carry_along_floor, last_speed, make_pipe

from driftform.testing.bodies import cylinder_body
from driftform.water.flow import KARMAN

SPEED = 6.6 * FOOT


def balance_gap(ratio):
    """Return the velocity of a long neutral cylinder on the axis over the mean velocity of the water."""
    return (1 + ratio**0.5) / (1 + ratio**2.5)


def average_profile(ratio):
    """Return the mean of the logarithmic law over the section of a body on the floor, over the mean velocity of the water."""
    r, angle = np.meshgrid(ratio * np.sqrt((np.arange(400) + 0.5) / 400), 2 * np.pi * (np.arange(400) + 0.5) / 400)
    wall = 1 - np.hypot(1 - ratio + r * np.cos(angle), r * np.sin(angle))
    friction = make_pipe(SPEED, BORE, 1.0).friction_velocity() / SPEED
    return 1 + friction / KARMAN * float((1.5 + np.log(np.maximum(wall, 1e-3))).mean())


def measure():
    """Return rows of what is compared, measured and found."""
    rows = []
    for ratio in (0.39, 0.6, 0.8, 0.89):
        r = ratio * BORE / 2
        for friction, named in ((0.2, ""), (0.0, ", no friction")):
            flight = carry_along_floor(cylinder_body(8 * r, r), 1.19, SPEED, BORE, 8.0, friction)
            rows.append((f"d/D {ratio}{named}", "up to 1.15", last_speed(flight) / SPEED))
        rows.append((f"d/D {ratio}, profile over its section", "", average_profile(ratio)))
    return rows + [(f"d/D {k}, the gap's balance", "1.05 to 1.5 if neutral", balance_gap(k)) for k in (0.39, 0.6, 0.89)]
