"""Spheres released on a floor

Source: Y. H. Tee, D. Barros and E. K. Longmire, Motion of finite-size spheres released in a turbulent boundary layer, International
Journal of Multiphase Flow 133 (2020), 103462, from the abstract: spheres of 1.006, 1.054 and 1.152 times the water's density and
of 58 or 122 viscous units were released from rest on a smooth floor at friction Reynolds numbers of 680 and 1320. Those with enough
shear lifted off at first and came down again; the denser ones slid along the floor, later rolled, and made small hops.

Driftform: spheres of 6.35 mm (a quarter of an inch: our assumption) in a pipe whose radius and velocity have these viscous units,
with friction 0.3 and `drag = "strips"`; the greatest height of the lowest point, over the diameter.

Left out: gusts, which vanish at the floor, and the lift of a spin (Magnus), to which the authors attribute the later hops. The
lift is that of the shear, which fades as the sphere gains the water's speed.

Met: which spheres lift off and which stay on the floor. The abstract states no height.
"""

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
