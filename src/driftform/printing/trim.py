"""Trim: the ballast that makes a weighed print fly as simulated, and its flight without."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from driftform.errors import InputError, WorkFailedError
from driftform.faults import require_files
from driftform.geometry.mass_elements import (
    MassElement,
    combine,
    core_element,
    printed_hull_element,
    reweigh,
)
from driftform.interfaces import Exporter, ExportJob
from driftform.pipeline import Pipeline
from driftform.printing.ballast import (
    FOAM,
    MATERIALS,
    NEGLIGIBLE,
    Piece,
    RequiredBallast,
    place_ballast,
    place_nearest,
    required_ballast,
)
from driftform.types import Agent

GRAMS_FOR_KG = 20
"""A printed mass of more than this many times the simulated one was given in another unit."""

LEAD = MATERIALS["lead"]
"""kg/m3, of the ballast where nothing else is asked for."""


@dataclass(frozen=True)
class PrintWeight:
    """What a print weighs.

    Attributes
    ----------
    mass
        with its core, kg.
    cog
        x of the centre of gravity of both, m; ``None`` for where the hull's material has it.
    source
        of ``cog``: ``"measured"``, ``"hull"`` (its material) or ``"kit"`` (the parts of the kit).
    """

    mass: float
    cog: float | None
    source: str


def weigh_print(
    agent: Agent,
    mass: float | None,
    cog: float | None,
    measure_kit: Callable[[], tuple[float, float]] | None = None,
) -> PrintWeight:
    """Return what a print weighs, from what was measured of it and what its kit weighs.

    Parameters
    ----------
    agent
        as simulated.
    mass
        of the print with its core, kg; ``None`` for that of its kit.
    cog
        x of its centre of gravity, m; ``None`` if it was not measured.
    measure_kit
        returns mass (kg) and centre of gravity (m) of the kit with its core; ``None`` for a hull in one piece.

    Raises
    ------
    InputError
        if the mass is missing.
    """
    core = agent.body.core.mass
    if mass is None and (measure_kit is None or cog is not None):
        raise InputError("--printed-mass is missing: weigh the print with its core in, kg")
    if mass is not None and (cog is not None or measure_kit is None or mass <= core):
        return PrintWeight(mass, cog, "hull" if cog is None else "measured")
    assert measure_kit is not None
    whole, x = measure_kit()
    if mass is None:
        return PrintWeight(whole, x, "kit")
    # The core's mass is known, at the origin: the difference is spread as the parts of the kit are.
    return PrintWeight(mass, (mass - core) / mass * (whole * x / (whole - core)), "kit")


def measure_kit(exporter: Exporter[Any], job: ExportJob) -> tuple[float, float]:
    """Return mass (kg) and centre of gravity (x, m) of a kit with its core, as its exporter accounts for them.

    Raises
    ------
    WorkFailedError
        if the exporter does not account for them.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"{job.name}{exporter.suffix}"
        written = require_files(exporter.write(job, path), exporter)
    for file in written:
        for row in file.facts.get("kit", {}).get("balance", ()):
            if row["of"] == "printed":
                return float(row["mass_kg"]), float(row["cog_mm"]) / 1000
    raise WorkFailedError(
        f"exporter '{exporter.name}' does not report how its kit balances; weigh the kit, and leave --kit out"
    )


def trim_agent(
    pipeline: Pipeline, agent: Agent, name: str, weight: PrintWeight, ballast_density: float = LEAD
) -> dict[str, Any]:
    """Return the ballast that makes a print fly as simulated, and the flights with and without it.

    The document is that of ``driftform trim --json``; SI units throughout.

    Parameters
    ----------
    pipeline
        the scenario, and how the agent flies.
    agent
        as simulated.
    name
        what people call it.
    weight
        of the print.
    ballast_density
        kg/m3.

    Raises
    ------
    InputError
        if the weight cannot be that of this agent, or the ballast floats.
    WorkFailedError
        if it cannot be flown at all. A flight that fails has ``None`` for its fitness, and the reason in ``ends``.
    """
    _check(agent, name, weight, ballast_density)
    printed = reweigh(agent, weight.mass, weight.cog)
    required = required_ballast(agent.mass, printed.mass)
    trimmed, remedy = _load(pipeline, agent, weight, required, ballast_density)
    agents = {"simulated": agent, "untrimmed": printed} | ({"trimmed": trimmed} if trimmed else {})
    flights = dict(zip(agents, pipeline.fly_named(list(agents.values()), name), strict=True))
    targets = pipeline.scenario.target_names
    scores = {
        case: dict(zip(targets, pipeline.fitness.score(flight, pipeline.scenario, agents[case]), strict=True))
        for case, flight in flights.items()
        if flight.failure is None
    }
    return {
        "agent": name,
        "simulator": pipeline.simulator.name,
        "simulated_mass": agent.mass.mass,
        "simulated_cog": agent.mass.cog[0],
        "printed_mass": weight.mass,
        "printed_cog": printed.mass.cog[0],
        "cog_source": weight.source,
        "aft_end": agent.body.outer[:, 0].min(),
        "ballast_mass": required.mass,
        "ballast_x": required.x,
        **remedy,
        **{case: scores.get(case) for case in ("simulated", "untrimmed", "trimmed")},
        "ends": {
            case: {
                "t": flight.t[-1],
                "position": flight.position[-1],
                "reason": str(flight.end),
                "failed": flight.end.failed,
            }
            for case, flight in flights.items()
        },
    }


def _check(agent: Agent, name: str, weight: PrintWeight, density: float) -> None:
    body, simulated, mass, x = agent.body, agent.mass, weight.mass, weight.cog
    if not (math.isfinite(mass) and mass > body.core.mass):
        raise InputError(
            f"--printed-mass {mass:g}: should be more than the core's {body.core.mass:g} kg: weigh the print with its core in"
        )
    if mass > GRAMS_FOR_KG * simulated.mass:
        raise InputError(
            f"--printed-mass {mass:g}: is in kg, and {name} was simulated with {simulated.mass:.4g} kg; "
            f"{mass:g} g are {mass / 1000:g}"
        )
    aft, fore = float(body.outer[:, 0].min()), float(body.outer[:, 0].max())
    if x is not None:
        if not aft < x < fore:
            raise InputError(
                f"--printed-cog {x:g}: lies outside the body, which reaches from x {aft:.4f} to {fore:.4f} m"
            )
        hull = mass * x / (mass - body.core.mass)
        if not aft < hull < fore:
            raise InputError(
                f"--printed-cog {x:g}: with its core at x 0, the hull alone would balance at x {hull:.4f} m, outside the "
                f"body ({aft:.4f} to {fore:.4f} m); weigh and balance it with its core in"
            )
    if not 1 < density < 1e5:
        raise InputError(
            f"--ballast-density {density:g}: should be a density in kg/m3, such as 11340 for lead"
        )


def _load(
    pipeline: Pipeline, agent: Agent, weight: PrintWeight, required: RequiredBallast, density: float
) -> tuple[Agent | None, dict[str, Any]]:
    """The agent with its ballast or buoyancy, ``None`` if there is no room for it, and what that is."""
    body, fluid = agent.body, pipeline.scenario.fluid
    hull = printed_hull_element(body, weight.mass, weight.cog)
    elements = [hull, core_element(body)]
    if density <= fluid.density and required.mass > 0:
        raise InputError(
            f"--ballast-density {density:g}: is no more than the water's {fluid.density:g} kg/m3"
        )
    pieces: tuple[Piece, ...] = ()
    buoyancy = None
    trimmed: Agent | None
    if abs(required.mass) < NEGLIGIBLE:
        trimmed = _combine(agent, elements)
    elif required.mass > 0:
        pieces = place_ballast(body, required, density) or place_nearest(body, required, density)
        trimmed = _combine(agent, elements + [piece.element for piece in pieces]) if pieces else None
    else:
        trimmed, buoyancy = _lift(agent, elements, required, fluid.density)
        buoyancy["hull_excess"] = -required.mass / hull.mass
    residual = None
    if trimmed is not None and buoyancy is None:
        residual = trimmed.mass.mass * trimmed.mass.cog[0] - agent.mass.mass * agent.mass.cog[0]
    return trimmed, {
        "pieces": [
            {
                "mass": piece.element.mass,
                "x": piece.element.x,
                "start": piece.start,
                "end": piece.end,
                "diameter": piece.diameter,
            }
            for piece in pieces
        ],
        "residual_moment": residual,
        "buoyancy": buoyancy,
    }


def _combine(agent: Agent, elements: Sequence[MassElement]) -> Agent:
    return replace(agent, mass=combine(elements, agent.mass))


def _lift(
    agent: Agent, elements: Sequence[MassElement], required: RequiredBallast, water: float
) -> tuple[Agent, dict[str, Any]]:
    """With foam on the outside that carries the excess weight; the water does not feel its shape."""
    volume = -required.mass / (water - FOAM)
    aft, fore = agent.body.outer[0, 0], agent.body.outer[-1, 0]
    x = float(np.clip(required.x if required.x is not None else 0.0, aft, fore))
    loaded = _combine(agent, [*elements, MassElement(FOAM * volume, x)])
    displaced = agent.mass.volume + volume
    cob = (agent.mass.volume * agent.mass.cob[0] + volume * x) / displaced
    mass = replace(loaded.mass, volume=displaced, cob=np.array([cob, 0.0, 0.0]))
    return replace(agent, mass=mass), {"volume": volume, "density": FOAM, "x": x}
