"""An agent in a scenario as plain arrays: all that the compiled equations of motion read."""

from dataclasses import dataclass

import numpy as np

from driftform.dynamics.inertia import added_mass_at, rigid_body_mass
from driftform.scenario import Scenario
from driftform.types import Agent, Body, FloatArray

# Rows of the table that the kernels read; six columns each.
MASS = 0
INVERSE = 6
LINEAR = 12
QUADRATIC = 18
COG_COB = 24
CURRENT = 25
FORCES = 26
DAMPING_ORIGIN = 27
ROWS = 28


@dataclass(frozen=True, eq=False)
class FlightModel:
    """What the kernels read.

    Attributes
    ----------
    table
        (28, 6): total mass M_RB + M_A about the body's origin, its inverse, linear damping, quadratic damping;
        then one row each of (COG, COB), (current in the world frame, 0, 0, 0), (weight N, buoyancy N, 0 ...),
        and (point that the damping refers to, 1 where there is any damping, 0, 0).
    rims
        circles of the body that can touch a wall: x, r (m), spring (N/m), damper (N s/m), (k, 4).
    pipe
        rows of start (3), end (3), radius, (segments, 7).
    """

    table: FloatArray
    rims: FloatArray
    pipe: FloatArray


def flight_model(agent: Agent, scenario: Scenario) -> FlightModel:
    """Return the arrays for one flight."""
    mass, fluid, coefficients = agent.mass, scenario.fluid, agent.coefficients
    total = rigid_body_mass(mass) + added_mass_at(coefficients, np.zeros(3))
    inverse = mass_inverse(total, max(agent.body.length, agent.body.max_diameter))
    table = np.zeros((ROWS, 6))
    table[MASS : MASS + 6] = total
    table[INVERSE : INVERSE + 6] = inverse
    table[LINEAR : LINEAR + 6] = coefficients.linear_damping
    table[QUADRATIC : QUADRATIC + 6] = coefficients.quadratic_damping
    table[COG_COB, :3], table[COG_COB, 3:] = mass.cog, mass.cob
    table[CURRENT, :3] = scenario.current()
    table[FORCES, 0] = mass.mass * fluid.gravity
    table[FORCES, 1] = fluid.density * mass.volume * fluid.gravity
    table[DAMPING_ORIGIN, :3] = coefficients.origin
    table[DAMPING_ORIGIN, 3] = np.any(table[LINEAR:COG_COB])
    return FlightModel(table, _springs(touching_rims(agent.body), inverse, scenario), scenario.pipe.array())


def mass_inverse(total: FloatArray, length: float) -> FloatArray:
    """Invert a 6x6 mass matrix in units of kg and ``length``, so that its blocks are of one size.

    A direction without any inertia (roll of a massless body) gets no acceleration instead of an infinite one. A
    matrix that is not finite has an inverse of NaN, with which a flight fails at its first step.
    """
    if not np.isfinite(total).all():
        return np.full((6, 6), np.nan)
    scale = np.diag([1.0, 1.0, 1.0, 1 / length, 1 / length, 1 / length])
    inverse = scale @ np.linalg.pinv(scale @ total @ scale, rcond=1e-13, hermitian=True) @ scale
    # The inverse of a planar-symmetric body couples no plane with another; rounding must not either, or it
    # would seed an out-of-plane motion that the undamped equations then amplify.
    return np.where(np.abs(inverse) > 1e-14 * np.abs(inverse).max(), inverse, 0.0)


def touching_rims(body: Body) -> FloatArray:
    """Return (x, r) of the rims that can touch a wall, m, (k, 2).

    The bore of a pipe is convex, so a body is inside it exactly if its convex hull is: only vertices of the
    convex hull of the meridian can touch.
    """
    hull: list[tuple[float, float]] = []
    for x, r in body.outer[np.lexsort((body.outer[:, 1], body.outer[:, 0]))]:
        while len(hull) >= 2:
            (x0, r0), (x1, r1) = hull[-2], hull[-1]
            if (x1 - x0) * (r - r0) - (r1 - r0) * (x - x0) < 0:
                break
            hull.pop()
        hull.append((float(x), float(r)))
    return np.array([point for point in hull if point[1] > 0.0]).reshape(-1, 2)


def _springs(rims: FloatArray, inverse: FloatArray, scenario: Scenario) -> FloatArray:
    # 1 / (effective mass) of each rim against a push across the axis: J M^-1 J^T with J of a force along z.
    push = np.zeros((len(rims), 6))
    push[:, 2] = 1.0
    push[:, 4] = -rims[:, 0]
    effective = 1 / np.einsum("ki,ij,kj->k", push, inverse, push)
    omega, zeta = scenario.contact.frequency, scenario.contact.damping_ratio
    return np.column_stack([rims, effective * omega**2, 2 * zeta * effective * omega])
