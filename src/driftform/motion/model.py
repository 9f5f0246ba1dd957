"""An agent in a scenario as plain arrays: the input of the compiled equations of motion."""

import math
from typing import NamedTuple

import numpy as np

from driftform.agent.slices import slice_solid
from driftform.motion.fitting_contact import MOST_STANDOFF
from driftform.motion.impact import contact_law
from driftform.motion.inertia import added_mass_at, rigid_body_mass
from driftform.motion.inverse import invert_mass
from driftform.motion.surfaces import refined_surfaces, touching_surfaces
from driftform.motion.terminal import terminal_speed_across
from driftform.types import Agent, Body, Drag, FloatArray
from driftform.util.compiled import borrow, borrowing, compiled
from driftform.util.latest import keep_latest
from driftform.water import Scenario
from driftform.water.fittings import fitting_array, greatest_curvature, rim_spacing
from driftform.water.flow import TurbulentFlow
from driftform.water.profiles import UNIFORM
from driftform.water.scenario import Contact
from driftform.water.velocity import flow_array, gust_array, pipe_rows

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
FROUDE_KRYLOV, FRICTION, REACH = (30, 0), (30, 1), (30, 2)
ROUND_AREA, DIAMETER = (AXIAL_DRAG, 4), (AXIAL_DRAG, 5)
SPIN, SHEAR_VOLUME = (TAILS, 4), (TAILS, 5)
ACROSS, LENGTHWISE, BLOCKING, CENTRE = (32, 0), (32, 1), (32, 2), (32, 3)
AXISYMMETRIC = (32, 4)

_FEWEST, _MOST_SLICES = 16, 64

_NO_DRAG = Drag(np.empty((0, 4)))


class FlightModel(NamedTuple):
    """Input of the kernels; about the body's origin and in body axes unless noted otherwise.

    Attributes
    ----------
    table
        (33, 6): total mass M_RB + M_A, its inverse, linear damping, quadratic damping; then one row each of COG,
        COB, (point that the damping refers to, 1 if the body is damped), (the water's velocity in the world frame,
        1 if it is uniform and steady), axial drag (see :func:`driftform.motion.drag.axial_drag`) with round area and
        diameter;
        (mass, mass of the displaced water, gravity, density, viscosity, height of the free surface, infinite
        without one); (1 if the pressure gradient of accelerating water acts on the body, coefficient of friction,
        greatest distance of a surface from the origin); (x and lift area of the tail for
        motion ahead, the same for motion astern, spin, shear volume); (spread across and along, blocking diameter,
        centre of the drag of a sphere: see :class:`driftform.types.Drag`; 1 if a roll changes nothing).
    surfaces
        rims and domes of the body that can touch a wall: the five numbers of
        :func:`driftform.motion.surfaces.touching_surfaces`, greatest fall of the bore from its tangent within the
        radius (m), effective mass against a push along the wall (kg), (k, 7).
    law
        of the force of a contact, (8,): see :func:`driftform.motion.impact.contact_law`.
    pipe
        rows of start (3), unit vector downstream (3), length, radius, (segments, 8); (0, 8) in open water and for a pipe
        with parts.
    flow, gusts
        see :mod:`driftform.water.velocity`.
    slices
        of the displaced volume: x, radius (m), volume (m3), width (m), (n, 4); (0, 4) if the pipe is full.
    strips
        of drag: see :class:`driftform.types.Drag`, (n, 4); (0, 4) without any.
    touches
        room for what is known of each surface that touches, (surfaces, 10): in space its lever, the wall's normal, twice the
        energy of the spring, half of its derivatives by depth and angle, and the index of the surface.
    bristles
        of the surfaces, if there is friction: their deflections times the contact's frequency, world frame, m/s (rows
        of the first half), and room for the rates of these, m/s2 (second half); (2 surfaces, 3) or (0, 3). See
        :func:`driftform.motion.contact.wall_wrench`.
    fittings
        a pipe with parts, shared by all flights in it (:mod:`driftform.water.fittings`); ``None`` for a straight pipe and in open
        water, where nothing of it is compiled.
    """

    table: FloatArray
    surfaces: FloatArray
    law: FloatArray
    pipe: FloatArray
    flow: FloatArray
    gusts: FloatArray
    slices: FloatArray
    strips: FloatArray
    touches: FloatArray
    bristles: FloatArray
    fittings: FloatArray | None = None


def flight_model(agent: Agent, scenario: Scenario) -> FlightModel:
    """Return the arrays of an agent in a scenario."""
    mass, fluid, coefficients = agent.mass, scenario.fluid, agent.coefficients
    total = rigid_body_mass(mass) + added_mass_at(coefficients, np.zeros(3))
    inverse = invert_mass(total, max(agent.body.length, agent.body.max_diameter))
    fittings, (flow, current, pipe, contact) = fitting_array(scenario), _environment(scenario)
    surfaces = _surface_rows(agent.body, inverse, scenario)
    gusts = _gusts(agent, scenario)
    drag = coefficients.drag or _NO_DRAG
    table = np.zeros((ROWS, 6))
    table[MASS : MASS + 6], table[INVERSE : INVERSE + 6] = total, inverse
    table[LINEAR : LINEAR + 6] = coefficients.linear_damping
    table[QUADRATIC : QUADRATIC + 6] = coefficients.quadratic_damping
    table[COG, :3], table[COB, :3] = mass.cog, mass.cob
    table[DAMPING_POINT, :3] = coefficients.origin
    table[DAMPED] = table[LINEAR:COG].any()
    table[CURRENT, :3] = current
    table[STEADY] = flow[0] == UNIFORM and not len(gusts) and fittings is None
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
    table[AXISYMMETRIC] = _is_axisymmetric(table)
    table[BODY_MASS], table[DISPLACED_MASS] = mass.mass, fluid.density * mass.volume
    table[GRAVITY], table[DENSITY], table[VISCOSITY] = fluid.gravity, fluid.density, fluid.viscosity
    table[WATER_LEVEL] = np.inf if fluid.water_level is None else fluid.water_level
    table[FROUDE_KRYLOV] = fluid.flow_force == "full"
    table[FRICTION] = contact.friction
    standoff = 0.0 if fittings is None else MOST_STANDOFF * surfaces[:, 5]
    reach = np.hypot(surfaces[:, 0], surfaces[:, 1]) + surfaces[:, 2] + standoff
    table[REACH] = reach.max(initial=0.0)
    viscosity = fluid.density * fluid.viscosity
    radius = 0.5 * agent.body.max_diameter
    law = contact_law(inverse, contact.frequency, contact.restitution, viscosity, radius)
    return FlightModel(
        table,
        surfaces,
        law,
        pipe.copy(),
        flow.copy(),
        gusts,
        np.empty((0, 4)) if fluid.water_level is None else _buoyancy_slices(agent),
        _drag_strips(agent),
        np.zeros((len(surfaces), 10)),
        np.zeros((2 * len(surfaces) if contact.friction > 0.0 else 0, 3)),
        fittings,
    )


@keep_latest
def _environment(scenario: Scenario) -> tuple[FloatArray, FloatArray, FloatArray, Contact]:
    """Return what does not depend on the agent: flow, mean current (m/s), straight pipe and contact."""
    return flow_array(scenario), scenario.current(), pipe_rows(scenario), scenario.calibrated_contact()


def pack(model: FlightModel) -> FloatArray:
    """Return all arrays of a model but its fittings as one, which is cheaper to pass to a kernel; see :func:`unpack`."""
    arrays = [array for array in model[:-1] if array is not None]
    flat: list[FloatArray] = [np.array([float(len(array)) for array in arrays])]
    flat.extend(array.ravel() for array in arrays)
    return np.concatenate(flat)


@borrowing
def unpack(values: FloatArray, fittings: FloatArray | None) -> FlightModel:
    """Return the model that :func:`pack` put into one array, with its fittings; its arrays share that memory."""
    surfaces = 10 + 6 * int(values[0])
    law = surfaces + 7 * int(values[1])
    pipe = law + int(values[2])
    flow = pipe + 8 * int(values[3])
    gusts = flow + int(values[4])
    slices = gusts + 12 * int(values[5])
    strips = slices + 4 * int(values[6])
    touches = strips + 4 * int(values[7])
    bristles = touches + 10 * int(values[8])
    return FlightModel(
        borrow(values, 10, (int(values[0]), 6)),
        borrow(values, surfaces, (int(values[1]), 7)),
        borrow(values, law, (int(values[2]),)),
        borrow(values, pipe, (int(values[3]), 8)),
        borrow(values, flow, (int(values[4]),)),
        borrow(values, gusts, (int(values[5]), 12)),
        borrow(values, slices, (int(values[6]), 4)),
        borrow(values, strips, (int(values[7]), 4)),
        borrow(values, touches, (int(values[8]), 10)),
        borrow(values, bristles, (int(values[9]), 3)),
        _borrow_fittings(fittings),
    )


@borrowing
def _borrow_fittings(fittings: FloatArray | None) -> FloatArray | None:
    # numba compiles no branch for an argument that is None.
    return borrow(fittings, 0, (fittings.shape[0],)) if fittings is not None else None


@compiled
def _is_axisymmetric(table: FloatArray) -> bool:
    """Return True if mass, damping and all centres of a table are the same after a roll."""
    for row in (COG, COB, DAMPING_POINT):
        if table[row, 1] != 0.0 or table[row, 2] != 0.0:
            return False
    for row in (MASS, LINEAR, QUADRATIC):
        largest, change = 0.0, 0.0
        for i in range(row, row + 6):
            for j in range(6):
                largest = max(largest, abs(table[i, j]))
        # A roll turns the pairs sway, heave and pitch, yaw: it changes what couples one with surge or roll, and each
        # block of two pairs that is not a scale and a turn.
        for i in range(0, 6, 3):
            for j in range(0, 6, 3):
                up, low = table[row + i + 1], table[row + i + 2]
                change = max(
                    change,
                    abs(table[row + i, j + 1]),
                    abs(table[row + i, j + 2]),
                    abs(up[j]),
                    abs(low[j]),
                    abs(up[j + 1] - low[j + 2]),
                    abs(up[j + 2] + low[j + 1]),
                )
        if not (math.isfinite(largest) and change <= 1e-12 * largest):
            return False
    return True


def _surface_rows(body: Body, inverse: FloatArray, scenario: Scenario) -> FloatArray:
    if scenario.pipe.is_open or scenario.pipe.straight is not None:
        surfaces = touching_surfaces(body)
    else:
        surfaces = refined_surfaces(body, rim_spacing(scenario.pipe.layout))
    rows = np.empty((len(surfaces), 7))
    rows[:, :5] = surfaces
    # A bore of radius R falls away from its tangent by r^2 / (2 R) within r.
    if scenario.pipe.is_open:
        rows[:, 5] = 0.0
    elif scenario.pipe.straight is not None:
        rows[:, 5] = surfaces[:, 1] ** 2 / scenario.pipe.layout.narrowest
    else:
        rows[:, 5] = (surfaces[:, 1] + surfaces[:, 2]) ** 2 * greatest_curvature(scenario.pipe.layout)
    _fill_effective_masses(rows, inverse)
    return rows


@compiled
def _fill_effective_masses(surfaces: FloatArray, inverse: FloatArray) -> None:
    """Fill the last number of each surface: the smaller of the masses (kg) that a push along the axis moves, and one around it."""
    for k in range(surfaces.shape[0]):
        row = surfaces[k]
        x, r = row[0], row[1] + row[2]
        # 1 / (effective mass) of a push at (x, 0, r) is J M^-1 J^T, with J of a force along the axis, and around it.
        along = inverse[0, 0] + inverse[0, 4] * r + r * inverse[4, 0] + r * inverse[4, 4] * r
        around = (
            inverse[1, 1]
            - inverse[1, 3] * r
            + inverse[1, 5] * x
            - r * inverse[3, 1]
            + r * inverse[3, 3] * r
            - r * inverse[3, 5] * x
            + x * inverse[5, 1]
            - x * inverse[5, 3] * r
            + x * inverse[5, 5] * x
        )
        row[6] = min(1.0 / along, 1.0 / around)


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
