"""Heavy cylinders that a pipe's flow carries."""

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
