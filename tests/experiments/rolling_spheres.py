"""Spheres that roll along a smooth bed

Source: P. Y. Julien and B. Bounvilay, Velocity of rolling bed load particles, Journal of Hydraulic Engineering 139 (2013), from
the abstract: on smooth beds, steel balls of 1.6 to 19 mm and glass marbles of 14.5 to 29.3 mm rolled within 30 % of the
velocity of the water at their top, at up to 20 times the friction velocity u*, with little influence of their density.

Driftform: such spheres in a smooth pipe of 200 mm, in the logarithmic law at 0.8 m/s, from rest on the floor, with friction 0.3
and `drag = "strips"`. A flume falls: so does the pipe, by u*² / (g R_h) with the hydraulic radius R_h = 50 mm, which the
abstract does not state. Two rows of each sphere are on a level floor, one of these without friction.

Left out: the friction of the water on a sphere that spins fast; the model has that of creeping motion. On a level floor all are
slower than the water at their top: they follow the water at their middle, 0.88 to 0.92 as fast, and its couple holds back what
friction makes roll, most of all the smallest ball, whose middle is in the buffer layer.

Met: all speeds over that of the water at the top. Over u*, the two largest are a tenth above "up to 20", since their weight drives
them down the fall that we assume: on a level floor they have 18.6 and 19.9.
"""

from rolling import carry_along_floor, last_speed, make_pipe

from driftform.testing.bodies import spheroid_body
from driftform.water.velocity import flow_array, pipe_rows, water_motion

SPEED, BORE = 0.8, 0.2

TOP = ", over the water at its top"

SPHERES = ((0.0016, 8.02), (0.0048, 8.02), (0.019, 8.02), (0.0145, 2.6), (0.0293, 2.6))
"""Diameters, m, and densities over that of the water."""


def measure():
    """Return rows of what is compared, measured and found."""
    rows, level = [], make_pipe(SPEED, BORE, 1.0)
    friction_velocity = level.friction_velocity()
    slope = friction_velocity**2 / (9.81 * BORE / 4)
    for diameter, density in SPHERES:
        body = spheroid_body(diameter / 2, diameter / 2, edges=100)
        top = water_motion((0.0, 0.0, diameter - BORE / 2), 0.0, pipe_rows(level), flow_array(level))[0][0]
        what = f"{'steel' if density > 3 else 'glass'}, {1000 * diameter:g} mm"
        for name, friction, fall in ((TOP, 0.3, slope), (", level", 0.3, 0.0), (", level, no friction", 0.0, 0.0)):
            # A sphere follows the water within some multiples of d G / (C_d U).
            horizon = 400 * diameter * density / SPEED
            velocity = last_speed(carry_along_floor(body, density, SPEED, BORE, horizon, friction, fall))
            rows.append((f"{what}{name}", "0.7 to 1.3" if name == TOP else "", velocity / top))
            if name == TOP:
                rows.append((f"{what}, over u*", "up to 20", velocity / friction_velocity))
    return rows
