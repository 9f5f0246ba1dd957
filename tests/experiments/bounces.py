"""Spheres that bounce in liquids

Source: P. Gondret, M. Lance and L. Petit, Bouncing motion of spherical particles in fluids, Physics of Fluids 14 (2002), 643.
Steel spheres fell through silicon oil onto a glass plate; the heights of their bounces are read from the published
curves. Sphere of 3 mm in oil of 10.7 mm2/s, impact at 0.585 m/s, a Stokes number of 152; sphere of 6 mm in oil of
103.6 mm2/s, a Stokes number of 27.

Driftform: steel spheres (7800 kg/m3) in oil of 935 kg/m3 that touch the floor of a wide pipe at the speed of the
impact, with `contact.restitution = 0.97`, added mass 1/2 and the drag of a sphere. Steel on glass is in contact for
microseconds: `contact.frequency = 5000`. Heights are of the lowest point, times
since the impact.

The dry value 0.97 was not checked against the paper.

Left out: the history force. The law of the restitution is a fit to many spheres; near a Stokes number of 27, where it falls
steeply, single measured rebounds differ from it as much as this one does.
"""

import math

import numpy as np

from driftform.hydrodynamics.drag import estimate_drag
from driftform.scenario import Contact, FlightLimits, Fluid, Pipe, Release, Scenario, Segment, UniformFlow
from driftform.testing.agents import solid_agent
from driftform.testing.bodies import spheroid_body
from driftform.types import Coefficients
from driftform_native.simulator import NativeOptions, NativeSimulator

BORE = 1.0
OIL, STEEL, DRY = 935.0, 7800.0, 0.97
CASES = (
    (152, 0.0015, 1.070e-5, ((7.466, 0.0384), (2.234, 0.1064), (0.520, 0.1404)), (0.0834, 0.130)),
    (27, 0.003, 1.036e-4, ((1.972, 0.0192),), (0.042,)),
)
"""Stokes number, radius (m), viscosity (m2/s), apexes (mm, s) and later contacts (s)."""


def bounce(stokes, radius, viscosity):
    """Return times and heights (m) of a sphere's lowest point, from its impact.

    The authors' Stokes number is without added mass.
    """
    speed = 9 * viscosity * OIL * stokes / (STEEL * 2 * radius)
    body = spheroid_body(radius, radius, edges=200)
    added = OIL * 4 / 3 * math.pi * radius**3 / 2
    coefficients = Coefficients(np.diag([added] * 3 + [0.0] * 3), drag=estimate_drag(body, viscosity, 0.0))
    scenario = Scenario(
        pipe=Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=BORE),)),
        flow=UniformFlow(speed=0.0),
        fluid=Fluid(density=OIL, viscosity=viscosity),
        release=Release(position=(1.0, 0.0, radius - BORE + 1e-6), velocity=(0.0, 0.0, -speed)),
        contact=Contact(restitution=DRY, frequency=5000.0),
        flight=FlightLimits(horizon=0.2),
    )
    simulator = NativeSimulator(NativeOptions(accuracy=1e-5, max_step=5e-4))
    flight = simulator.simulate(solid_agent(body, STEEL, coefficients), scenario)
    assert not flight.end.failed
    return flight.t, flight.position[:, 2] + BORE - radius


def find_bounces(t, height, count):
    """Return the first apexes (m, s) and the contacts after them (s)."""
    rises = np.diff(height)
    tops = 1 + np.flatnonzero((rises[:-1] > 0) & (rises[1:] <= 0) & (height[1:-1] > 1e-4))
    touches = 1 + np.flatnonzero((height[:-1] > 0) & (height[1:] <= 0))
    apexes = [(float(height[k]), float(t[k])) for k in tops[:count]]
    return apexes, [
        float(t[touches[t[touches] > when][0]]) for _, when in apexes if (t[touches] > when).any()
    ]


def measure():
    """Return rows of what is compared, measured and found."""
    rows = []
    for stokes, radius, viscosity, apexes, contacts in CASES:
        found, touched = find_bounces(*bounce(stokes, radius, viscosity), len(apexes))
        for k, ((height, when), (top, at)) in enumerate(zip(apexes, found, strict=True), 1):
            rows.append((f"St {stokes}, bounce {k}: height, mm", height, 1000 * top))
            rows.append((f"St {stokes}, bounce {k}: time of its top, s", when, at))
        for k, (when, at) in enumerate(zip(contacts, touched, strict=False), 2):
            rows.append((f"St {stokes}, contact {k}, s", when, at))
    return rows
