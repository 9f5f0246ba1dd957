"""Drag -> quadratic damping about the centre of gravity, for other simulators."""

import numpy as np

from driftform.motion import forces
from driftform.types import Agent, FloatArray
from driftform.water import Fluid

MIN_SPEED = 0.05
"""Least speed, m/s, at which drag is converted: a neutral agent does not move through the water."""


def linear_damping(agent: Agent) -> FloatArray:
    """Return the linear damping D_1 about the centre of gravity, (6, 6)."""
    coefficients = agent.coefficients
    return forces.shift_origin(coefficients.linear_damping, agent.mass.cog - coefficients.origin)


def reference_speed(agent: Agent, fluid: Fluid) -> float:
    """Return the speed, m/s, at which an agent with drag by strips rises or sinks across its axis."""
    drag = agent.coefficients.drag
    if drag is None:
        return MIN_SPEED
    _, across = forces.terminal_speeds(drag, agent.mass.net_buoyancy(fluid), True, fluid.density, fluid.viscosity)
    return max(across, MIN_SPEED)


def quadratic_damping(agent: Agent, fluid: Fluid, speed: float) -> FloatArray:
    """Return D_2 about the centre of gravity, (6, 6): force and moment are -D_2 |nu| nu, component by component.

    Column j reproduces the force and moment of motion along axis j alone at ``speed`` (m/s), or of rotation about it
    at the rate at which the ends of the agent, half its length from the middle, move at that speed; both are means over
    the two directions. The effects of motion along several axes add up here. They do not with strips, whose drag
    depends on the total lateral speed. Quadratic damping about the centre of gravity is returned unchanged.
    """
    rates = np.repeat([speed, 2 * speed / agent.body.length], 3)
    columns = []
    for j, rate in enumerate(rates):
        nu = np.zeros(6)
        nu[j] = rate
        columns.append((quadratic_wrench(agent, fluid, -nu) - quadratic_wrench(agent, fluid, nu)) / (2 * rate**2))
    return np.column_stack(columns)


def quadratic_wrench(agent: Agent, fluid: Fluid, nu: FloatArray) -> FloatArray:
    """Return the force and the moment about the centre of gravity of all but linear damping, N and N m, (6,).

    ``nu`` holds the velocity of the centre of gravity relative to the water, m/s, and the angular velocity, rad/s, both
    in body axes, (6,).
    """
    coefficients, cog = agent.coefficients, agent.mass.cog
    velocity, omega = nu[:3], nu[3:]
    wrench = np.zeros(6)

    def add(force: FloatArray, point: FloatArray) -> None:
        wrench[:3] += force
        wrench[3:] += np.cross(point - cog, force)

    there = np.concatenate((velocity + np.cross(omega, coefficients.origin - cog), omega))
    damping = -coefficients.quadratic_damping @ (np.abs(there) * there)
    wrench[3:] += damping[3:]
    add(damping[:3], coefficients.origin)
    drag = coefficients.drag
    if drag is not None:
        x, y, z = (velocity - np.cross(omega, cog)).tolist()
        p, q, r = omega.tolist()
        own = forces.still_water_wrench(drag, (x, y, z), (p, q, r), fluid.density, fluid.viscosity)
        wrench[3:] += own[3:]
        add(own[:3], np.zeros(3))
    return wrench
