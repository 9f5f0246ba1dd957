"""Spheres that bounce in liquids."""

import math

import numpy as np
from solids import solid_agent

from driftform.motion.forces.body_drag import estimate_drag
from driftform.motion.forces.drag import sphere_drag
from driftform.motion.forces.impact import LUBRICATION
from driftform.testing.bodies import spheroid_body
from driftform.types import Coefficients
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import UniformFlow
from driftform.water.scenario import Contact, FlightLimits, Release
from driftform_native.simulator import NativeOptions, NativeSimulator

BORE = 1.0
STEEL, DRY = 7800.0, 0.97
CASES = (
    (152, 0.0015, 1.070e-5, 935.0, ((7.466, 0.0384), (2.234, 0.1064), (0.520, 0.1404)), (0.0834, 0.130)),
    (27, 0.003, 1.036e-4, 965.0, ((1.972, 0.0192),), (0.042,)),
)
"""Stokes number, radius (m), viscosity (m2/s) and density (kg/m3) of the oil, apexes (mm, s) and later contacts (s)."""


def impact_speed(stokes, radius, viscosity, oil):
    """Return the speed (m/s) of an impact; the authors' Stokes number is without added mass."""
    return 9 * viscosity * oil * stokes / (STEEL * 2 * radius)


def bounce(stokes, radius, viscosity, oil):
    """Return times and heights (m) of a sphere's lowest point, from its impact."""
    speed = impact_speed(stokes, radius, viscosity, oil)
    body = spheroid_body(radius, radius, edges=200)
    added = oil * 4 / 3 * math.pi * radius**3 / 2
    coefficients = Coefficients(np.diag([added] * 3 + [0.0] * 3), drag=estimate_drag(body, viscosity, 0.0))
    scenario = Scenario(
        pipe=Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=BORE),)),
        flow=UniformFlow(speed=0.0),
        fluid=Fluid(density=oil, viscosity=viscosity),
        release=Release(position=(1.0, 0.0, radius - BORE + 1e-6), velocity=(0.0, 0.0, -speed)),
        contact=Contact(restitution=DRY, frequency=5000.0),
        flight=FlightLimits(horizon=0.2),
    )
    simulator = NativeSimulator(NativeOptions(accuracy=1e-5, max_step=5e-4))
    flight = simulator.simulate(solid_agent(body, STEEL, coefficients), scenario)
    assert not flight.end.failed
    return flight.t, flight.position[:, 2] + BORE - radius


def bounce_with_history(stokes, radius, viscosity, oil, step=5e-5):
    """Return height (m) and time (s) of the first top, and the time of the contact after it, of a point with history force.

    The kernel is that of Mei and Adrian (1992) with f_H = 0.75 + 0.105 Re and the speed of the moment.
    """
    volume, shear = 4 / 3 * math.pi * radius**3, 6 * math.pi * radius * viscosity * oil
    mass, weight = (STEEL + oil / 2) * volume, (STEEL - oil) * volume * Fluid().gravity
    impact = impact_speed(stokes, radius, viscosity, oil)
    ages = (np.arange(20000) + 0.5) * step
    early = (math.pi * viscosity * ages / radius**2) ** 0.25

    def accelerate(speed):
        drag = sphere_drag((speed, 0.0, 0.0), oil, viscosity, math.pi * radius**2, 2 * radius)[0]
        drag -= 6 * math.pi * radius * viscosity * oil * speed
        return (drag - weight) / mass

    def remember(speed, changes):
        factor = 0.75 + 0.105 * 2 * radius * abs(speed) / viscosity
        late = math.sqrt(math.pi / 2 * abs(speed) ** 3 / (radius * viscosity * factor**3))
        kernel = shear / (early[: len(changes)] + late * ages[: len(changes)]) ** 2
        return -float(kernel[::-1] @ changes) / mass

    fall = [0.0]
    while fall[-1] > -0.995 * impact and len(fall) * step < 0.25:
        fall.append(fall[-1] + step * accelerate(fall[-1]))
    rebound = DRY * math.exp(-LUBRICATION * shear * radius / (mass * impact)) * impact
    count, changes = len(fall), np.zeros(len(ages))
    changes[:count] = [*(np.diff(fall) * impact / -fall[-1]), rebound + impact]
    speed, height, top = rebound, 0.0, (0.0, 0.0)
    while height >= 0:
        changes[count] = step * (accelerate(speed) + remember(speed, changes[:count]))
        height += step * (speed + changes[count] / 2)
        speed += changes[count]
        count += 1
        duration = step * (count - len(fall))
        top = max(top, (height, duration))
    return *top, duration


def find_apex(t, height):
    """Return height (m) and time (s) of the top of the parabola through three samples, whose times are those of steps."""
    curve = np.polyfit(t - t[1], height, 2)
    top = -curve[1] / (2 * curve[0])
    return float(np.polyval(curve, top)), float(t[1] + top)


def find_bounces(t, height, count):
    """Return the first apexes (m, s) and the contacts after them (s)."""
    rises = np.diff(height)
    tops = 1 + np.flatnonzero((rises[:-1] > 0) & (rises[1:] <= 0) & (height[1:-1] > 1e-4))
    touches = 1 + np.flatnonzero((height[:-1] > 0) & (height[1:] <= 0))
    apexes = [find_apex(t[k - 1 : k + 2], height[k - 1 : k + 2]) for k in tops[:count]]
    return apexes, [float(t[touches[t[touches] > when][0]]) for _, when in apexes if (t[touches] > when).any()]


def measure():
    """Return rows of what is compared, measured and found."""
    rows = []
    for stokes, radius, viscosity, oil, apexes, contacts in CASES:
        found, touched = find_bounces(*bounce(stokes, radius, viscosity, oil), len(apexes))
        for k, ((height, when), (top, at)) in enumerate(zip(apexes, found, strict=True), 1):
            rows.append((f"St {stokes}, bounce {k}: height, mm", height, 1000 * top))
            rows.append((f"St {stokes}, bounce {k}: time of its top, s", when, at))
        for k, (when, at) in enumerate(zip(contacts, touched, strict=False), 2):
            rows.append((f"St {stokes}, contact {k}, s", when, at))
    stokes, radius, viscosity, oil, apexes, contacts = CASES[0]
    height, top, contact = bounce_with_history(stokes, radius, viscosity, oil)
    rows.append((f"with history, St {stokes}, bounce 1: height, mm", apexes[0][0], 1000 * height))
    rows.append((f"with history, St {stokes}, bounce 1: time of its top, s", apexes[0][1], top))
    rows.append((f"with history, St {stokes}, contact 2, s", contacts[0], contact))
    return rows
