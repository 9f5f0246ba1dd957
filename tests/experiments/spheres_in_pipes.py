"""Heavy spheres that roll along a pipe

Source: H. S. Ellis, The pipeline flow of capsules, part 5: an experimental investigation of the transport by water of single
spherical capsules with density greater than that of the water, Canadian Journal of Chemical Engineering 42 (1964), from the
abstract: in a pipe of 1 1/4 inches and above 2 feet per second, spheres of more than half of the bore were carried at 1.04
to 1.08 times the mean velocity of the water, mostly rolling.

Driftform: spheres of 0.7 of the bore and 2.7 times the density of the water, released at rest on the floor, in the
logarithmic law of a smooth pipe, with friction 0.3 and `drag = "strips"`; the velocity in the last of 6 s.

Left out: the flow through the gap, which differs above and below a sphere on the floor. The drag of a body that fills much of
the bore is increased as measured on the axis of a tube.
"""

import math

import numpy as np
from solids import solid_agent

from driftform.motion.forces.body_drag import estimate_drag
from driftform.testing.bodies import spheroid_body
from driftform.types import Coefficients
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import LogLawFlow
from driftform.water.scenario import Contact, FlightLimits, Release
from driftform_native.simulator import NativeOptions, NativeSimulator

BORE = 1.25 * 0.0254
FLUID = Fluid(density=998.0, viscosity=1.0e-6)
FOOT = 0.3048


def roll(speed, ratio=0.7, density=2.7, horizon=6.0):
    """Return the flight of a heavy sphere on the floor of the pipe, in water of a mean speed (m/s)."""
    radius = ratio * BORE / 2
    body = spheroid_body(radius, radius, edges=100)
    added = FLUID.density * 4 / 3 * math.pi * radius**3 / 2
    coefficients = Coefficients(np.diag([added] * 3 + [0.0] * 3), drag=estimate_drag(body, FLUID.viscosity, 0.0))
    scenario = Scenario(
        pipe=Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(20.0, 0.0, 0.0), radius=BORE / 2),)),
        flow=LogLawFlow(speed=speed),
        fluid=FLUID,
        release=Release(position=(0.0, 0.0, radius - BORE / 2), velocity="rest"),
        contact=Contact(friction=0.3),
        flight=FlightLimits(horizon=horizon),
    )
    return NativeSimulator(NativeOptions()).simulate(solid_agent(body, density * FLUID.density, coefficients), scenario)


def measure():
    """Return rows of what is compared, measured and found."""
    rows = []
    for feet in (2.5, 5.0):
        flight = roll(feet * FOOT)
        assert not flight.end.failed
        late = flight.t > flight.t[-1] - 1.0
        along = (flight.position[-1, 0] - flight.position[late][0, 0]) / (flight.t[-1] - flight.t[late][0])
        spin = float(np.linalg.norm(flight.velocity[-1, 3:]))
        rows.append((f"{feet} ft/s: velocity over that of the water", "1.04 to 1.08", along / (feet * FOOT)))
        rolling = spin * 0.7 * BORE / 2 / along
        rows.append((f"{feet} ft/s: speed of the surface over that of rolling", "mostly rolling", rolling))
    return rows
