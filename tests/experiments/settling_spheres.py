"""Spheres that settle and rise."""

import math

import numpy as np
from scipy.integrate import solve_ivp
from solids import solid_agent

from driftform.motion.forces.body_drag import estimate_drag
from driftform.motion.path.interpolation import interpolate_positions
from driftform.testing.bodies import spheroid_body
from driftform.types import Coefficients
from driftform.water import Fluid, Pipe, Scenario
from driftform.water.flow import UniformFlow
from driftform.water.scenario import FlightLimits, Release
from driftform_native.simulator import NativeOptions, NativeSimulator

TEN_CATE = ((970.0, 0.373, 0.0363), (965.0, 0.212, 0.0571), (962.0, 0.113, 0.0869), (960.0, 0.058, 0.1226))
"""Density (kg/m3) and viscosity (Pa s) of the oil, and the greatest speed (m/s)."""


def fall(radius, density, fluid, horizon):
    """Return the flight of a sphere from rest in open water."""
    body = spheroid_body(radius, radius, edges=200)
    displaced = fluid.density * 4 / 3 * math.pi * radius**3
    coefficients = Coefficients(
        np.diag([displaced / 2] * 3 + [0.0] * 3), drag=estimate_drag(body, fluid.viscosity, 0.0)
    )
    scenario = Scenario(
        pipe=Pipe(segments=()),
        flow=UniformFlow(speed=0.0),
        fluid=fluid,
        release=Release(velocity="rest"),
        flight=FlightLimits(horizon=horizon),
    )
    return NativeSimulator(NativeOptions()).simulate(solid_agent(body, density, coefficients), scenario)


def clift_gauvin(reynolds):
    """Return C_d of a sphere."""
    return 24 / reynolds * (1 + 0.15 * reynolds**0.687) + 0.42 / (1 + 42500 * reynolds**-1.16)


def distance_from_three_terms():
    """Return the greatest difference of the depths of a steel sphere, relative to that of the three terms."""
    d, density, fluid, horizon = 0.008, 7800.0, Fluid(density=998.0, viscosity=1.0e-6), 0.5

    def rate(_, y):
        speed = max(y[1], 1e-12)
        drag = 0.75 * fluid.density / d * clift_gauvin(speed * d / fluid.viscosity) * speed**2
        return [y[1], ((density - fluid.density) * 9.81 - drag) / (density + fluid.density / 2)]

    times = np.linspace(0.05, horizon, 50)
    depth = solve_ivp(rate, (0, horizon), [0, 0], t_eval=times, rtol=1e-9, atol=1e-12).y[0]
    flown = -interpolate_positions(fall(d / 2, density, fluid, horizon), times)[:, 2]
    return float(np.abs(flown / depth - 1).max())


def measure():
    """Return rows of what is compared, measured and found."""
    rows = []
    for number, (density, viscosity, measured) in enumerate(TEN_CATE, 1):
        flight = fall(0.0075, 1120.0, Fluid(density=density, viscosity=viscosity / density), 4.0)
        found = float(-flight.velocity[flight.position[:, 2] > -0.12, :3].min())
        rows.append((f"ten Cate, oil {number}: greatest speed, m/s", measured, found))
    light = fall(0.02, 300.0, Fluid(density=998.0, viscosity=1.0e-6), 3.0)
    return [
        *rows,
        ("Rostami: depth, off the three terms by, %", "1 to 4.3", 100 * distance_from_three_terms()),
        ("Horowitz: swing aside, mm", "zigzags", f"{1000 * math.hypot(*light.position[-1, :2]):.1f}"),
    ]
