"""Neutral bodies that a pipe's flow carries

Source: H. S. Ellis, The pipeline flow of capsules, part 3: an experimental investigation of the transport by water of single
cylindrical and spherical capsules with density equal to that of the water, Canadian Journal of Chemical Engineering 42
(1964), from the abstract: in a pipe of 1 1/4 inches, bodies as dense as water were carried at 1.05 to 1.5 times the mean
velocity of the flow, the smaller the faster. In turbulent flow, a small body on the axis cannot be faster than the water
there.

Driftform: bodies as dense as the water, released on the axis with the mean velocity, in the logarithmic law at 1 m/s in a
smooth pipe, with `drag = "strips"`; the velocity after 3 s. Cylinders are 4 diameters long. In gusts: 60 spheres without
friction, released evenly over what their centres can reach; their mean velocity over 100 diameters of the pipe.

Left out: the flow through the gap around a body that fills the bore; bodies of more than 0.3 of it are out of range. In gusts a
small sphere also visits the slow water at the wall. The fastest of the abstract may have been in laminar flow: its velocities
begin at 0.2 feet per second.

Met: all rows, also where bodies are out of range.
"""

from carried import Carrying
from rolling import BORE, carry, last_speed, make_pipe

from driftform.testing.bodies import cylinder_body, spheroid_body


def measure():
    """Return rows of what is compared, measured and found."""
    rows, pipe = [], make_pipe(1.0, BORE, 3.0, velocity=(1.0, 0.0, 0.0))
    for shape, ratios in (("sphere", (0.1, 0.2, 0.31, 0.5, 0.69)), ("cylinder", (0.1, 0.2, 0.31, 0.5, 0.69, 0.89))):
        for ratio in ratios:
            r = ratio * BORE / 2
            body = spheroid_body(r, r, edges=100) if shape == "sphere" else cylinder_body(8 * r, r)
            rows.append((f"{shape}, d/D {ratio}", "1.05 to 1.5", last_speed(carry(body, 1.0, pipe), 0.5)))
    for ratio in (0.31, 0.69):
        r = ratio * BORE / 2
        carrying = Carrying(spheroid_body(r, r), BORE / 2, 1.0, (100,))
        [found] = carrying.observe(60)
        rows.append((f"sphere in gusts, d/D {ratio}", "1.05 to 1.5", found.speed * carrying.even_speed()))
    return rows
