"""Spheres that roll along a smooth bed."""

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
