"""Cylinders that fall broadside, or with a heavy end."""

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
