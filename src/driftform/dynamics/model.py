"""An agent in a scenario as plain arrays: the input of the compiled equations of motion."""

from typing import NamedTuple

import numpy as np

from driftform.dynamics.flow import UNIFORM, flow_array, gust_array
from driftform.dynamics.inertia import added_mass_at, rigid_body_mass
from driftform.dynamics.terminal import terminal_speed_across
from driftform.geometry.slices import slice_solid
from driftform.scenario import Scenario, TurbulentFlow
from driftform.types import Agent, Body, Drag, FloatArray
from driftform.util.compiled import borrow, compiled

# Rows of the table that the kernels read; six columns each.
MASS, INVERSE, LINEAR, QUADRATIC = 0, 6, 12, 18
COG, COB = 24, 25
DAMPING_POINT = 26
CURRENT = 27
AXIAL_DRAG = 28
TAILS = 31
ROWS = 33

# Indices of single numbers in it.
DAMPED = (DAMPING_POINT, 3)
STEADY = (CURRENT, 3)
BODY_MASS, DISPLACED_MASS = (29, 0), (29, 1)
GRAVITY, DENSITY, VISCOSITY, WATER_LEVEL = (29, 2), (29, 3), (29, 4), (29, 5)
FROUDE_KRYLOV, FRICTION, CONTACT_RATE, REACH = (30, 0), (30, 1), (30, 2), (30, 3)
ROUND_AREA, DIAMETER = (AXIAL_DRAG, 4), (AXIAL_DRAG, 5)
SPIN, SHEAR_VOLUME = (TAILS, 4), (TAILS, 5)
ACROSS, LENGTHWISE, BLOCKING, CENTRE = (32, 0), (32, 1), (32, 2), (32, 3)

_FEWEST, _MOST_SLICES = 16, 64


class FlightModel(NamedTuple):
    """Input of the kernels; about the body's origin and in body axes unless noted otherwise.

    Attributes
    ----------
    table
        (33, 6): total mass M_RB + M_A, its inverse, linear damping, quadratic damping; then one row each of COG,
        COB, (point that the damping refers to, 1 if the body is damped), (the water's velocity in the world frame,
        1 if it is uniform and steady), axial drag (see :func:`driftform.dynamics.drag.axial_drag`) with round area and
        diameter;
        (mass, mass of the displaced water, gravity, density, viscosity, height of the free surface, infinite
        without one); (1 if the pressure gradient of accelerating water acts on the body, coefficient of friction,
        fastest rate of friction 1/s, greatest distance of a rim from the origin); (x and lift area of the tail for
        motion ahead, the same for motion astern, spin, shear volume); (spread across and along, blocking diameter,
        centre of the drag of a sphere): see :class:`driftform.types.Drag`.
    rims
        circles of the body that can touch a wall: x, r (m), spring (N/m), damper (N s/m), effective mass against a
        push along the wall (kg), greatest fall of the bore from its tangent within the radius (m), (k, 6).
    pipe
        rows of start (3), unit vector downstream (3), length, radius, (segments, 8).
    flow, gusts
        see :mod:`driftform.dynamics.flow`.
    slices
        of the displaced volume: x, radius (m), volume (m3), width (m), (n, 4); (0, 4) if the pipe is full.
    strips
        of drag: see :class:`driftform.types.Drag`, (n, 4); (0, 4) without any.
    """

    table: FloatArray
    rims: FloatArray
    pipe: FloatArray
    flow: FloatArray
    gusts: FloatArray
    slices: FloatArray
    strips: FloatArray


def flight_model(agent: Agent, scenario: Scenario) -> FlightModel:
    """Return the arrays of an agent in a scenario."""
    mass, fluid, coefficients = agent.mass, scenario.fluid, agent.coefficients
    total = rigid_body_mass(mass) + added_mass_at(coefficients, np.zeros(3))
    inverse = invert_mass(total, max(agent.body.length, agent.body.max_diameter))
    rims = _rim_springs(touching_rims(agent.body), inverse, scenario)
    flow, gusts = flow_array(scenario), _gusts(agent, scenario)
    drag = coefficients.drag or Drag(np.empty((0, 4)))
    table = np.zeros((ROWS, 6))
    table[MASS : MASS + 6], table[INVERSE : INVERSE + 6] = total, inverse
    table[LINEAR : LINEAR + 6] = coefficients.linear_damping
    table[QUADRATIC : QUADRATIC + 6] = coefficients.quadratic_damping
    table[COG, :3], table[COB, :3] = mass.cog, mass.cob
    table[DAMPING_POINT, :3] = coefficients.origin
    table[DAMPED] = np.any(table[LINEAR:COG])
    table[CURRENT, :3] = scenario.current()
    table[STEADY] = flow[0] == UNIFORM and not len(gusts) and len(scenario.pipe.segments) <= 1
    table[AXIAL_DRAG] = (
        drag.friction_area,
        drag.length,
        drag.ahead,
        drag.astern,
        drag.round_area,
        drag.diameter,
    )
    table[TAILS] = *drag.wake_ahead, *drag.wake_astern, drag.spin, drag.shear_volume
    table[ACROSS], table[LENGTHWISE] = drag.spread
    table[BLOCKING], table[CENTRE] = drag.blocking, drag.centre
    table[BODY_MASS], table[DISPLACED_MASS] = mass.mass, fluid.density * mass.volume
    table[GRAVITY], table[DENSITY], table[VISCOSITY] = fluid.gravity, fluid.density, fluid.viscosity
    table[WATER_LEVEL] = np.inf if fluid.water_level is None else fluid.water_level
    table[FROUDE_KRYLOV] = fluid.flow_force == "full"
    table[FRICTION], table[CONTACT_RATE] = scenario.contact.friction, 2 * scenario.contact.frequency
    table[REACH] = np.sqrt((rims[:, :2] ** 2).sum(axis=1).max(initial=0.0))
    return FlightModel(
        table,
        rims,
        _pipe_rows(scenario),
        flow,
        gusts,
        np.empty((0, 4)) if fluid.water_level is None else _buoyancy_slices(agent),
        _drag_strips(agent),
    )


def pack(model: FlightModel) -> FloatArray:
    """Return all arrays of a model as one, which is cheaper to pass to a kernel; see :func:`unpack`."""
    flat: list[FloatArray] = [np.array([float(len(array)) for array in model])]
    flat.extend(array.ravel() for array in model)
    return np.concatenate(flat)


@compiled
def unpack(values: FloatArray) -> FlightModel:
    """Return the model that :func:`pack` put into one array; its arrays share that memory."""
    values = borrow(values)
    rims = 7 + 6 * int(values[0])
    pipe = rims + 6 * int(values[1])
    flow = pipe + 8 * int(values[2])
    gusts = flow + int(values[3])
    cuts = gusts + 12 * int(values[4])
    strips = cuts + 4 * int(values[5])
    return FlightModel(
        values[7:rims].reshape(-1, 6),
        values[rims:pipe].reshape(-1, 6),
        values[pipe:flow].reshape(-1, 8),
        values[flow:gusts],
        values[gusts:cuts].reshape(-1, 12),
        values[cuts:strips].reshape(-1, 4),
        values[strips:].reshape(-1, 4),
    )


def invert_mass(total: FloatArray, length: float) -> FloatArray:
    """Invert a 6x6 mass matrix in units of kg and ``length`` (m), so that its blocks are of similar size.

    A direction without inertia (roll of a massless body) gets an acceleration of zero instead of an infinite one. The
    inverse of a matrix that is not finite is NaN, and the flight fails at its first step.
    """
    if not np.isfinite(total).all():
        return np.full((6, 6), np.nan)
    scale = np.diag([1.0, 1.0, 1.0, 1 / length, 1 / length, 1 / length])
    values, vectors = np.linalg.eigh(scale @ total @ scale)
    kept = values > 1e-13 * values.max()
    axes = scale @ vectors[:, kept]
    inverse = (axes / values[kept]) @ axes.T
    # The inverse for a body with a plane of symmetry does not couple motions in and out of that plane. Rounding must
    # not couple them either: it would start an out-of-plane motion that the undamped equations amplify.
    return np.where(np.abs(inverse) > 1e-14 * np.abs(inverse).max(), inverse, 0.0)


def touching_rims(body: Body) -> FloatArray:
    """Return (x, r) of the rims that can touch a wall, m, (k, 2).

    The bore of a pipe is convex, so a body is inside exactly if its convex hull is: only vertices of the
    convex hull of the meridian can touch.
    """
    x, r = body.outer.T
    hull = _upper_hull(body.outer[np.lexsort((r, x))])
    return hull[hull[:, 1] > 0.0]


@compiled
def _upper_hull(points: FloatArray) -> FloatArray:
    """Return the vertices of the upper convex hull of points (n, 2) that are sorted by x (Andrew 1979)."""
    hull = np.empty_like(points)
    count = 0
    for k in range(points.shape[0]):
        x, r = points[k, 0], points[k, 1]
        while count >= 2:
            x0, r0, x1, r1 = hull[count - 2, 0], hull[count - 2, 1], hull[count - 1, 0], hull[count - 1, 1]
            if (x1 - x0) * (r - r0) - (r1 - r0) * (x - x0) < 0.0:
                break
            count -= 1
        hull[count, 0], hull[count, 1] = x, r
        count += 1
    return hull[:count]


def _rim_springs(rims: FloatArray, inverse: FloatArray, scenario: Scenario) -> FloatArray:
    # 1 / (effective mass) of each rim against a push across the axis is J M^-1 J^T, with J of a force along z.
    omega, zeta = scenario.contact.frequency, scenario.contact.damping_ratio
    push = np.zeros((3, len(rims), 6))
    x, r = rims.T
    push[0, :, 2], push[0, :, 4] = 1.0, -x
    # Along the wall at the top of the rim: along the axis, and around it.
    push[1, :, 0], push[1, :, 4] = 1.0, r
    push[2, :, 1], push[2, :, 3], push[2, :, 5] = 1.0, -r, x
    across, along, around = 1 / np.einsum("aki,ij,akj->ak", push, inverse, push)
    # A bore of radius R falls away from its tangent by r^2 / (2 R) within r.
    narrowest = min((segment.radius for segment in scenario.pipe.segments), default=np.inf)
    return np.column_stack(
        [rims, across * omega**2, 2 * zeta * across * omega, np.minimum(along, around), r**2 / narrowest]
    )


def _pipe_rows(scenario: Scenario) -> FloatArray:
    rows = scenario.pipe.array()
    axis = rows[:, 3:6] - rows[:, :3]
    length = np.linalg.norm(axis, axis=1, keepdims=True)
    return np.column_stack([rows[:, :3], axis / length, length, rows[:, 6]])


def _gusts(agent: Agent, scenario: Scenario) -> FloatArray:
    """Return the gusts that an agent meets: with drag, they know its terminal speed and its length."""
    drag, flow = agent.coefficients.drag, scenario.flow
    if drag is None or not isinstance(flow, TurbulentFlow) or flow.crossing == 0:
        return gust_array(scenario)
    net = agent.mass.net_buoyancy(scenario.fluid)
    slip = terminal_speed_across(drag, net, scenario.fluid.density, scenario.fluid.viscosity)
    return gust_array(scenario, slip, agent.body.length)


def _drag_strips(agent: Agent) -> FloatArray:
    drag = agent.coefficients.drag
    if drag is None:
        return np.empty((0, 4))
    if len(drag.strips) > 0:
        return np.array(drag.strips)
    # A body with axial drag only: a strip without drag gives the share of the body that is under water.
    return np.array([[agent.mass.cob[0], agent.body.max_diameter, agent.body.length, 0.0]])


def _buoyancy_slices(agent: Agent) -> FloatArray:
    """Return slices about a quarter of the diameter wide: x, radius (m), volume (m3), width (m), (n, 4)."""
    body = agent.body
    count = int(np.clip(4 * body.length / body.max_diameter, _FEWEST, _MOST_SLICES))
    x, volume, width = slice_solid(body.outer, count).T
    # If the displaced volume differs from that of the contour, the slices keep the displaced volume and its centre.
    volume = volume * agent.mass.volume / volume.sum()
    x = x + agent.mass.cob[0] - x @ volume / volume.sum()
    return np.column_stack([x, np.sqrt(volume / (np.pi * width)), volume, width])
