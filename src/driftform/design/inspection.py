"""An agent in numbers: modules, mass, buoyancy and added mass, how it moves, warnings, and departures from its design."""

import math
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np

from driftform.agent import MassElement, hull_mass
from driftform.errors import WorkFailedError, describe_error
from driftform.motion.forces.body_drag import estimate_drag, wake_factor
from driftform.motion.forces.inertia import added_mass_at, largest_added_mass_ratio, rigid_body_mass
from driftform.motion.forces.limits import list_limits
from driftform.motion.forces.model import flight_model
from driftform.motion.forces.terminal import terminal_speeds
from driftform.motion.path.stability import stable_rest
from driftform.pipeline import Pipeline
from driftform.plugins.genome_text import write_genome
from driftform.plugins.registry import registry
from driftform.types import Agent, Body, Detail, FloatArray
from driftform.water import Calibration, Fluid, Scenario
from driftform.water.factors import Factors
from driftform.water.fittings import fitting_array, wall_array
from driftform.water.flow import GridFlow
from driftform.water.parts.grid_flow import VALUES
from driftform.water.regime import warn_of_regime

LEAD = 11_340.0
"""Density of lead, kg/m3 (CRC Handbook of Chemistry and Physics, at 20 degrees C)."""

BED = 0.25
"""Travel of a common desktop printer, m."""

GRAM = 1e-3
"""kg"""

LARGEST_LAGGED_RATIO = 17 / 3
"""Largest eigenvalue of M_RB^-1 M_A up to which added mass from a filtered acceleration is stable: 2/0.3 - 1."""

DENSITY_CHANGE = 5e-4
"""Relative difference in the water's density that is worth a warning: a print of 200 cm3 floats by 0.1 g more."""

SPEED_CHANGE = 0.01
"""Relative difference in the speed of the current that is worth a warning: a third of the disturbance by default."""

MASS_CHANGE = 1e-4
"""Difference in mass that is worth a warning, kg: what a kitchen scale shows."""

SLOW = 0.01
"""Terminal speed of a body, over the speed of the fastest water, below which it says little of its own."""


def inspect_agent(pipeline: Pipeline, agent: Agent, name: str, target: str | None = None) -> dict[str, Any]:
    """Return what ``driftform inspect --json`` prints of an agent; SI units throughout.

    Args:
        pipeline: its scenario, models and simulator.
        agent: the agent, made from a genome.
        name: what people call it.
        target: that it was evolved for; ``None`` for the one that it comes closest to.
    """
    assert agent.genome is not None
    body, mass, coefficients = agent.body, agent.mass, agent.coefficients
    fluid = pipeline.scenario.fluid
    own, added = rigid_body_mass(mass), added_mass_at(coefficients, np.zeros(3))
    lambda_max = largest_added_mass_ratio(mass, coefficients)
    net = mass.net_buoyancy(fluid)
    rest = stable_rest(flight_model(agent, pipeline.scenario))
    morphology = agent.morphology
    sides = [] if morphology is None else [("aft", m) for m in morphology.aft[::-1]]
    sides += [] if morphology is None else [("fore", m) for m in morphology.fore]
    return {
        "agent": name,
        "genome": write_genome(pipeline.grammar, agent.genome),
        "modules": [{"side": side, "length": m.length, "tilt_deg": float(np.rad2deg(m.tilt))} for side, m in sides],
        "length": body.length,
        "max_diameter": body.max_diameter,
        "mass": mass.mass,
        "hull_mass": hull_mass(body),
        "core_mass": body.core.mass,
        "ballast_mass": body.ballast.volume * body.ballast_density,
        "pockets": [{**asdict(pocket), "putty": MassElement.of_putty(pocket).mass} for pocket in body.pockets],
        "trim_range": body.trim_range(fluid.density),
        "fittings": [_describe_detail(detail, body, fluid) for detail in body.fittings.details],
        "volume": mass.volume,
        "net_buoyancy": net,
        "cog": mass.cog,
        "cob": mass.cob,
        "inertia": mass.inertia,
        "added_mass": coefficients.added_mass,
        "added_mass_origin": coefficients.origin,
        "hydrodynamics": pipeline.hydrodynamics.name,
        "rest": {
            "pitch_deg": float(np.rad2deg(rest.pitch)),
            "height": rest.height,
            "slowest_period": rest.slowest_period,
            "eigenvalues": [[value.real, value.imag] for value in rest.eigenvalues.tolist()],
        },
        # Of weight and buoyancy about the COG: that of the level body is the largest.
        "righting_moment": float(fluid.density * mass.volume * fluid.gravity * abs(mass.cob[0] - mass.cog[0])),
        "terminal_speeds": _terminal_speeds(agent, fluid, net, rest.pitch),
        "lambda_max": lambda_max,
        "strength": pipeline.builder.describe_strength(body, fluid),
        "seals": body.fittings.glands,
        "calibration": describe_calibration(pipeline.scenario.calibration),
        "sensitivity": _measure_sensitivity(pipeline, agent, name, target),
        "warnings": _list_warnings(agent, pipeline.scenario, float((own + added)[2, 2]), lambda_max),
    }


_BLUNT, _SLIP = 2.0, 0.1
"""Drag coefficient of a long plate across the flow, no less than that of other blunt shapes (Hoerner 1965, Fluid-Dynamic Drag,
section 3.4); and a speed through the water, m/s."""


def _describe_detail(detail: Detail, body: Body, fluid: Fluid) -> dict[str, Any]:
    """Return mass (kg) of a fitting, and the most drag (N) at 0.1 m/s that the flow model leaves out."""
    mass, drag = body.hull_density * detail.moments.volume, 0.5 * fluid.density * _BLUNT * detail.area * _SLIP**2
    return {"name": detail.name, "mass": mass, "drag_left_out": drag}


def describe_calibration(calibration: Calibration) -> dict[str, dict[str, float | None]]:
    """Return value, low and high of the factors that are not 1 or have an interval; ``None`` without an interval."""
    intervals = calibration.intervals
    found: dict[str, dict[str, float | None]] = {}
    for name in Factors.names:
        value = float(getattr(calibration.factors, name))
        if name in intervals:
            _, low, high = intervals[name]
            found[name] = {"value": value, "low": low, "high": high}
        elif value != 1.0:
            found[name] = {"value": value, "low": None, "high": None}
    return found


def compare_added_mass(pipeline: Pipeline, agent: Agent, name: str) -> dict[str, FloatArray]:
    """Return the added mass about the centre of buoyancy, (6, 6), by the models that need no options, and its own.

    The pipeline's own model has its options, the others have their defaults.

    Raises WorkFailedError if a model cannot compute it.
    """
    own, found = pipeline.hydrodynamics, {}
    for row in registry().seam("hydrodynamics"):
        needs_options = row.cls is None or any(field.is_required() for field in row.cls.Options.model_fields.values())
        if row.name == own.name or not needs_options:
            model = own if row.name == own.name else registry().create("hydrodynamics", row.name, {})
            try:
                coefficients = model.coefficients(agent.body, pipeline.scenario.fluid)
            except (ValueError, ArithmeticError, RuntimeError) as error:
                raise WorkFailedError(f"{name}: no added mass by '{row.name}': {describe_error(error)}") from None
            found[row.name] = added_mass_at(coefficients, agent.mass.cob)
    return found


def _terminal_speeds(agent: Agent, fluid: Fluid, net: float, pitch: float) -> dict[str, float]:
    """Speeds (m/s) at which damping, or drag by strips, with which the agent may not fly, carries the net weight."""
    fore_first = (net > 0) == (pitch < 0)
    drag, damping = agent.coefficients.drag, (agent.coefficients.linear_damping, agent.coefficients.quadratic_damping)
    if drag is None:
        linear, quadratic = (np.diag(matrix)[[0, 2]] for matrix in damping)
        if (linear + quadratic > 0).all():
            along, across = 2 * abs(net) / (linear + np.sqrt(linear**2 + 4 * quadratic * abs(net)))
            return {"along": float(along), "across": float(across)}
        factor = wake_factor(agent.coefficients, fluid.density * agent.mass.volume)
        drag = estimate_drag(agent.body, fluid.viscosity, factor)
    along, across = terminal_speeds(drag, net, fore_first, fluid.density, fluid.viscosity)
    return {"along": along, "across": across}


def _measure_sensitivity(pipeline: Pipeline, agent: Agent, name: str, target: str | None) -> dict[str, Any] | None:
    """Errors, in percent, of the agent and of one whose hull is a gram lighter or heavier; ``None`` if unknown."""
    names = pipeline.scenario.target_names
    try:
        found = measure_gram_sensitivity(pipeline, agent, name) if names else None
    except WorkFailedError:
        # An agent that cannot be flown is still a body, and `simulate` reports what is wrong with its flight.
        return None
    if found is None:
        return None
    errors = {
        name: dict(zip(found, row, strict=True))
        for name, row in zip(names, zip(*found.values(), strict=True), strict=True)
    }
    if target not in errors:
        target = min(errors, key=lambda name: float(errors[name]["as_simulated"]))
    return {"target": target, "errors": errors}


def measure_gram_sensitivity(pipeline: Pipeline, agent: Agent, name: str) -> dict[str, FloatArray] | None:
    """Return the errors (100 less the fitness) for each target, (targets,): as simulated, with a gram of hull less, and more.

    ``None`` if its hull has no gram to lose. The two are given apart and not as one slope: about the mass that was evolved
    for a target the error grows on either side. Raises WorkFailedError as :meth:`driftform.pipeline.Pipeline.simulate`.
    """
    if hull_mass(agent.body) <= GRAM:
        return None
    others = [
        MassElement.reweigh(agent, (MassElement.of_agent(agent), MassElement.of_hull(agent.body, gram)))
        for gram in (-GRAM, GRAM)
    ]
    errors = [100 - one.fitness for one in pipeline.simulate([agent, *others], name)]
    return dict(zip(("as_simulated", "lighter", "heavier"), errors, strict=True))


def _list_warnings(agent: Agent, scenario: Scenario, heaving: float, lambda_max: float) -> list[str]:
    """What a user must know; ``heaving`` is the mass, kg, that heave has to move, with that of the water."""
    body, mass = agent.body, agent.mass
    warnings = []
    core_density = body.core.mass / body.core.volume if body.core.mass else 0.0
    if core_density > LEAD:
        warnings.append(f"the core is denser than lead: {core_density:.0f} kg/m3")
    if (misfit := scenario.find_misfit(body)) is not None:
        warnings.append(misfit)
    net = mass.net_buoyancy(scenario.fluid)
    if not scenario.pipe.is_open and net != 0:
        time = math.sqrt(2 * scenario.pipe.layout.inlet.radius * heaving / abs(net))
        if time < 1.0:
            verb = "rises" if net > 0 else "sinks"
            warnings.append(f"level, it {verb} from the axis to the wall in {time:.2g} s: it is far from neutral")
    if lambda_max > LARGEST_LAGGED_RATIO:
        warnings.append(
            f"added mass up to {lambda_max:.1f} times its own: simulators that take it from the step before, "
            f"smoothed, diverge beyond {LARGEST_LAGGED_RATIO:.2f}"
        )
    if body.wall and (body.length > BED or body.max_diameter > BED):
        warnings.append(
            f"{1000 * body.length:.0f} mm long and {1000 * body.max_diameter:.0f} mm wide: "
            f"larger than the bed of a common printer ({1000 * BED:.0f} mm)"
        )
    return [*warnings, *list_doubts(agent, scenario)]


def list_doubts(agent: Agent, scenario: Scenario) -> list[str]:
    """Return in what agent and flow are outside of the ranges of the formulas that fly it, or hardly meant so, one line each."""
    return [*list_limits(agent, scenario), *warn_of_regime(scenario), *_warn_of_speeds(agent, scenario)]


def _warn_of_speeds(agent: Agent, scenario: Scenario) -> list[str]:
    """Return a line if a body is far slower than the water of a grid in open water, or faster than all of it."""
    flow, fluid = scenario.flow, scenario.fluid
    if not scenario.pipe.is_open or not isinstance(flow, GridFlow) or (array := fitting_array(scenario)) is None:
        return []
    # The coefficients of the splines bound the velocities.
    velocities = array[len(wall_array(scenario.pipe)) + VALUES :].reshape(-1, 3)
    water = flow.speed / flow.reference * float(np.linalg.norm(velocities, axis=1).max())
    net = agent.mass.net_buoyancy(fluid)
    own = max(_terminal_speeds(agent, fluid, net, -net).values())
    if SLOW * water <= own <= water:
        return []
    way = f"less than {100 * SLOW:g} % of" if own < water else "more than"
    return [
        f"its terminal speed, {own:.3g} m/s, is {way} that of the fastest water in flow.file, {water:.3g} m/s: do the units agree?"
    ]


def list_departures(agent: Agent, pipeline: Pipeline, designed: Agent, design: Pipeline) -> list[str]:
    """Return one line per difference between an agent, its water, pipe or wall, and those of its design.

    Args:
        agent, pipeline: the agent as it flies now.
        designed, design: the agent as it was evolved.
    """
    now, before = pipeline.scenario, design.scenario
    lines = [*_compare_water(now, before), *_compare_pipes(now, before)]
    if now.contact != before.contact:
        lines.append("the wall's restitution or friction is not that of its design")
    if pipeline.hydrodynamics.options.drag != design.hydrodynamics.options.drag:
        lines.append(
            f"drag is '{pipeline.hydrodynamics.options.drag}', and '{design.hydrodynamics.options.drag}' in its design"
        )
    mass, planned = agent.mass.mass, designed.mass.mass
    if abs(mass - planned) > MASS_CHANGE:
        lines.append(f"it weighs {1000 * mass:.1f} g, and {1000 * planned:.1f} g in its design")
    if not lines:
        return []
    net, wanted = agent.mass.net_buoyancy(now.fluid), designed.mass.net_buoyancy(before.fluid)
    effect = f"net buoyancy {net:+.3f} N, and {wanted:+.3f} N in its design"
    return [*lines, f"it was not evolved for this ({effect}): evolve again with these settings"]


def _compare_water(now: Scenario, before: Scenario) -> Iterator[str]:
    if abs(now.fluid.density / before.fluid.density - 1) > DENSITY_CHANGE:
        yield f"the water has {now.fluid.density:g} kg/m3, and {before.fluid.density:g} kg/m3 in its design"
    if now.flow.kind != before.flow.kind:
        yield f"flow.kind is '{now.flow.kind}', and '{before.flow.kind}' in its design"
    if abs(now.flow.speed - before.flow.speed) > SPEED_CHANGE * abs(before.flow.speed):
        yield f"the current has {now.flow.speed:g} m/s, and {before.flow.speed:g} m/s in its design"


def _compare_pipes(now: Scenario, before: Scenario) -> Iterator[str]:
    if now.pipe == before.pipe:
        return
    radii = [sorted({segment.radius for segment in scenario.pipe.segments}) for scenario in (now, before)]
    if radii[0] != radii[1]:
        shown, planned = (", ".join(f"{radius:g}" for radius in each) or "none" for each in radii)
        yield f"the pipe's radius is {shown} m, and {planned} m in its design"
    else:
        yield "the pipe's course is not that of its design"
