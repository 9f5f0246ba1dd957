"""Spheres released on a floor."""

from rolling import FLUID, carry_along_floor, make_pipe
from scipy.optimize import brentq

from driftform.testing.bodies import spheroid_body

DIAMETER = 0.00635


def fly_highest(density, units, reynolds):
    """Return the greatest height over the floor of a sphere of ``units`` viscous units, in diameters."""
    wanted = units * FLUID.viscosity / DIAMETER
    bore, radius = 2 * reynolds * FLUID.viscosity / wanted, DIAMETER / 2
    speed = brentq(lambda v: make_pipe(v, bore, 1.0).friction_velocity() - wanted, 0.05, 2.0)
    body = spheroid_body(radius, radius, edges=100)
    flight = carry_along_floor(body, density, speed, bore, 100 * DIAMETER / speed)
    off = (flight.position[:, 1:] ** 2).sum(axis=1) ** 0.5
    return float((bore / 2 - radius - off).max() / DIAMETER)


def measure():
    """Return rows of what is compared, measured and found."""
    measured = {1.006: "lifts off", 1.054: "", 1.152: "slides"}
    return [
        (f"{density} times the water, d+ {units}: height over d", found, fly_highest(density, units, reynolds))
        for units, reynolds in ((58, 680), (122, 1320))
        for density, found in measured.items()
    ]
