"""An agent in a scenario as named arrays: the input of the compiled equations of motion."""

import math
from typing import NamedTuple

import numpy as np

from driftform.agent.slices import slice_solid
from driftform.motion.forces.fields import NUMBERS, Records
from driftform.motion.forces.fitting_contact import MAX_STANDOFF
from driftform.motion.forces.impact import contact_law
from driftform.motion.forces.inertia import added_mass_at, rigid_body_mass
from driftform.motion.forces.inverse import invert_mass
from driftform.motion.forces.surfaces import refined_surfaces, touching_surfaces
from driftform.motion.forces.terminal import terminal_speed_across
from driftform.types import Agent, Body, Drag, FloatArray
from driftform.util.compiled import compiled
from driftform.util.latest import keep_latest
from driftform.water import Scenario
from driftform.water.fittings import fitting_array
from driftform.water.gusts import STATES
from driftform.water.parts.profiles import UNIFORM
from driftform.water.parts.rows import greatest_curvature, rim_spacing
from driftform.water.scenario import Contact
from driftform.water.velocity import ACCELERATION, SPEED, flow_array, gust_array, pipe_rows, set_gusts

_MIN_SLICES, _MAX_SLICES = 16, 64

_NO_DRAG = Drag(np.empty((0, 4)))


class FlightModel(NamedTuple):
    """Input of the kernels; about the body's origin and in body axes unless noted otherwise.

    Attributes:
        numbers: one record of :data:`driftform.motion.forces.fields.NUMBERS`, (1,).
        surfaces: rims and domes of the body that can touch a wall: the five numbers of
            :func:`driftform.motion.forces.surfaces.touching_surfaces`, greatest fall of the bore from its tangent within the
            radius (m), effective mass against a push along the wall (kg), (k, 7).
        pipe: rows of start (3), unit vector downstream (3), length, radius, (segments, 8); (0, 8) in open water and
            for a pipe with parts.
        flow, gusts: see :mod:`driftform.water.velocity`; ``flow`` has the gusts that this body meets.
        slices: of the displaced volume: x, radius (m), volume (m3), width (m), (n, 4); (0, 4) if the pipe is full.
        strips: of drag: see :class:`driftform.types.Drag`, (n, 4); (0, 4) without any.
        touches: room for what is known of each surface that touches, and for a row that ends them, (surfaces + 1,
            10): in space its lever, the wall's normal, twice the energy of the spring, half of its derivatives by
            depth and angle, and the index of the surface.
        bristles: of the surfaces, if there is friction: their deflections times the contact's frequency, world frame,
            m/s (rows of the first half), and room for the rates of these, m/s2 (second half); (2 surfaces, 3) or (0,
            3). See :func:`driftform.motion.forces.contact.wall_wrench`.
        eddies: states of the gusts, and room for their rates, (2, 4) or (0, 4) without gusts: see
            :mod:`driftform.water.gusts`.
        fittings: a pipe with parts, shared by all flights in it (:mod:`driftform.water.fittings`); ``None`` for a
            straight pipe and in open water, where nothing of it is compiled.
    """

    numbers: Records
    surfaces: FloatArray
    pipe: FloatArray
    flow: FloatArray
    gusts: FloatArray
    slices: FloatArray
    strips: FloatArray
    touches: FloatArray
    bristles: FloatArray
    eddies: FloatArray
    fittings: FloatArray | None = None


def flight_model(agent: Agent, scenario: Scenario) -> FlightModel:
    """Return the arrays of an agent in a scenario."""
    mass, fluid, coefficients = agent.mass, scenario.fluid, agent.coefficients
    total = rigid_body_mass(mass) + added_mass_at(coefficients, np.zeros(3))
    inverse = invert_mass(total, max(agent.body.length, agent.body.max_diameter))
    fittings, (flow, current, pipe, contact) = fitting_array(scenario), _environment(scenario)
    surfaces = _surface_rows(agent.body, inverse, scenario)
    flow, gusts = _set_gusts(agent, scenario, flow)
    drag = coefficients.drag or _NO_DRAG
    numbers = np.zeros(1, NUMBERS)
    n = numbers[0]
    n["mass"], n["inverse"] = total, inverse
    n["linear"], n["quadratic"] = coefficients.linear_damping, coefficients.quadratic_damping
    n["damping_point"] = coefficients.origin
    n["is_damped"] = coefficients.linear_damping.any() or coefficients.quadratic_damping.any()
    n["cog"], n["cob"] = mass.cog, mass.cob
    n["is_axisymmetric"] = _is_axisymmetric(numbers)
    n["body_mass"], n["displaced_mass"] = mass.mass, fluid.density * mass.volume
    n["gravity"], n["density"], n["viscosity"] = fluid.gravity, fluid.density, fluid.viscosity
    n["water_level"] = np.inf if fluid.water_level is None else fluid.water_level
    n["current"] = current
    # Water that a pipe with parts does not guide, as it is given from outside, is the same everywhere.
    n["is_steady"] = flow[0] == UNIFORM and flow[ACCELERATION] == 0.0 and (fittings is None or flow[SPEED] == 0.0)
    n["has_pressure_gradient"] = fluid.flow_force == "full"
    n["axial"] = drag.friction_area, drag.length, drag.ahead, drag.astern
    n["tails"] = *drag.wake_ahead, *drag.wake_astern
    n["round_area"], n["diameter"], n["centre"] = drag.round_area, drag.diameter, drag.centre
    n["spin"], n["shear_volume"], n["blocking"] = drag.spin, drag.shear_volume, drag.blocking
    n["creeping"], n["rubbing"] = drag.creeping, drag.rubbing
    n["spread_across"], n["spread_along"] = drag.spread
    standoff = 0.0 if fittings is None else MAX_STANDOFF * surfaces[:, 5]
    reach = np.hypot(surfaces[:, 0], surfaces[:, 1]) + surfaces[:, 2] + standoff
    n["reach"], n["friction"] = reach.max(initial=0.0), contact.friction
    n["curvature"] = 0.0 if fittings is None else greatest_curvature(scenario.pipe.layout)
    viscosity = fluid.density * fluid.viscosity
    radius = 0.5 * agent.body.max_diameter
    n["law"] = contact_law(inverse, contact.frequency, contact.restitution, viscosity, radius)[0]
    return FlightModel(
        numbers,
        surfaces,
        pipe.copy(),
        flow,
        gusts,
        np.empty((0, 4)) if fluid.water_level is None else _buoyancy_slices(agent),
        _drag_strips(agent),
        np.zeros((len(surfaces) + 1, 10)),
        np.zeros((2 * len(surfaces) if contact.friction > 0.0 else 0, 3)),
        np.zeros((2 if len(gusts) else 0, STATES)),
        fittings,
    )


@keep_latest
def _environment(scenario: Scenario) -> tuple[FloatArray, FloatArray, FloatArray, Contact]:
    """Return what does not depend on the agent: flow, mean current (m/s), straight pipe and contact."""
    return flow_array(scenario), scenario.current(), pipe_rows(scenario), scenario.calibrated_contact()


@compiled
def _is_axisymmetric(numbers: Records) -> bool:
    """Return True if mass, damping and all centres are the same after a roll."""
    n = numbers[0]
    for point in (n.cog, n.cob, n.damping_point):
        if point[1] != 0.0 or point[2] != 0.0:
            return False
    for matrix in (n.mass, n.linear, n.quadratic):
        largest, change = 0.0, 0.0
        for i in range(6):
            for j in range(6):
                largest = max(largest, abs(matrix[i, j]))
        # A roll turns the pairs sway, heave and pitch, yaw: it changes what couples one with surge or roll, and each
        # block of two pairs that is not a scale and a turn.
        for i in range(0, 6, 3):
            for j in range(0, 6, 3):
                up, low = matrix[i + 1], matrix[i + 2]
                change = max(
                    change,
                    abs(matrix[i, j + 1]),
                    abs(matrix[i, j + 2]),
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


def _set_gusts(agent: Agent, scenario: Scenario, flow: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the array of the flow with the gusts that an agent meets, and their walk.

    With drag, they know its terminal speed and its length.
    """
    flow, drag = flow.copy(), agent.coefficients.drag
    if not scenario.has_gusts:
        return flow, gust_array(scenario, flow)
    slip, length = 0.0, 0.0
    if drag is not None:
        net = agent.mass.net_buoyancy(scenario.fluid)
        slip = terminal_speed_across(drag, net, scenario.fluid.density, scenario.fluid.viscosity)
        length = agent.body.length
    set_gusts(flow, scenario, 0.5 * min(agent.body.max_diameter, agent.body.length), slip, length)
    return flow, gust_array(scenario, flow, length)


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
    count = int(np.clip(4 * body.length / body.max_diameter, _MIN_SLICES, _MAX_SLICES))
    x, volume, width = slice_solid(body.outer, count).T
    # If the displaced volume differs from that of the contour, the slices keep the displaced volume and its centre.
    volume = volume * agent.mass.volume / volume.sum()
    x = x + agent.mass.cob[0] - x @ volume / volume.sum()
    return np.column_stack([x, np.sqrt(volume / (np.pi * width)), volume, width])
