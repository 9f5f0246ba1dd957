"""Cylinders that fall broadside, or with a heavy end

Source: C_d of short cylinders across the flow at Re of 1e4 and more, F. M. White, Fluid Mechanics, 7th edition,
table 7.3: 0.74 at 5 diameters of length, 0.82 at 10. In falls of end-heavy cylinders in a water tank (Pennsylvania State
University), those as long as thick fell upright, and those of 4 diameters kept a tilt and drifted aside.

Driftform: homogeneous cylinders of 20 mm diameter and twice the water's density, released level and at rest; C_d from the
speed after 3 s. The end-heavy ones have the centre of gravity a tenth of the length off the middle; they are released
60 degrees from level, and compared are the angle between axis and vertical and the drift in the last 5 of 20 s.

Left out: the oscillations of cylinders that fall (Marchildon 1964: above Re = 300), since no vortex of the model is shed in
turns. The swing of the short cylinder is damped by the drag of its strips alone, and dies down slowly.

Met: both C_d within 3 %, and how each end-heavy cylinder falls.
"""

import math

import numpy as np
from solids import solid_agent

from driftform.agent import solid_of_revolution
from driftform.motion.forces.body_drag import estimate_drag, wake_factor
from driftform.testing.bodies import cylinder_body
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import Fluid, Pipe, Scenario
from driftform.water.flow import UniformFlow
from driftform.water.scenario import FlightLimits, Release
from driftform_native.simulator import NativeOptions, NativeSimulator
from driftform_panels.solve import PanelMethod, PanelOptions

FLUID = Fluid(density=998.0, viscosity=1.0e-6)
DIAMETER = 0.02


def drop(aspect, density, offset, pitch_deg, horizon, without=()):
    """Return agent and flight of a cylinder released at rest in open water."""
    body = cylinder_body(aspect * DIAMETER, DIAMETER / 2)
    coefficients = PanelMethod(PanelOptions()).coefficients(body, FLUID)
    factor = wake_factor(coefficients, FLUID.density * solid_of_revolution(body.outer).volume)
    drag = estimate_drag(body, FLUID.viscosity, factor, without)
    scenario = Scenario(
        pipe=Pipe(segments=()),
        flow=UniformFlow(speed=0.0),
        fluid=FLUID,
        release=Release(velocity="rest", pitch_deg=pitch_deg),
        flight=FlightLimits(horizon=horizon),
    )
    coefficients = type(coefficients)(coefficients.added_mass, coefficients.origin, drag=drag)
    agent = solid_agent(body, density, coefficients, offset * body.length)
    return agent, NativeSimulator(NativeOptions()).simulate(agent, scenario)


def broadside_coefficient(aspect):
    """Return C_d from the terminal speed, and the Reynolds number."""
    agent, flight = drop(aspect, 2 * FLUID.density, 0.0, 0.0, 3.0)
    speed = float(np.linalg.norm(flight.velocity[-1, :3]))
    weight = -agent.mass.net_buoyancy(FLUID)
    area = aspect * DIAMETER**2
    return weight / (0.5 * FLUID.density * area * speed**2), speed * DIAMETER / FLUID.viscosity


def end_heavy(aspect):
    """Return the least and greatest angle (degrees) between axis and vertical, and the drift over the fall."""
    _, flight = drop(aspect, 2 * FLUID.density, 0.1, 60.0, 20.0)
    late = flight.t > 15.0
    axes = np.array([matrix_from_quaternion(q)[:, 0] for q in flight.quaternion[late]])
    tilts = np.degrees(np.arccos(np.abs(axes[:, 2])))
    x, y, z = flight.position[-1] - flight.position[late][0]
    return float(tilts.min()), float(tilts.max()), math.hypot(x, y) / abs(z)


def measure():
    """Return rows of what is compared, measured and found."""
    rows = []
    for aspect, measured in ((5, 0.74), (10, 0.82)):
        found, reynolds = broadside_coefficient(aspect)
        rows.append((f"C_d broadside, {aspect} diameters long, Re = {reynolds:.1e}", measured, found))
    for aspect, measured in ((1, "upright"), (4, "constant, oblique")):
        least, most, drift = end_heavy(aspect)
        rows.append((f"end-heavy, {aspect} diameters long: tilt, degrees", measured, f"{least:.0f} to {most:.0f}"))
        rows.append(
            (f"the same, {aspect} diameters long: drift over fall", "0" if aspect == 1 else "> 0", f"{drift:.2f}")
        )
    return rows
