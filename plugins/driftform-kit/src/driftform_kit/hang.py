"""Trim in water: what a sealed print lacks by its net weight, and how it flies without.

The net weight decides a flight, and a scale shows it whatever the outside of the print is. Mass m and volume V of the design
weigh m - rho V in the fluid of the scenario. In a bucket of that fluid at another temperature the same agent weighs

    m - rho_b V_b,    V_b = V (1 + 3 alpha dT),

and more by what it displaces more there, since no pressure squeezes it. The volume of a print differs by some millilitres from V,
and this by a thousandth of that.
"""

import math
from typing import Any

from driftform import Design
from driftform.agent import MassElement
from driftform.errors import InputError
from driftform.types import Agent, Body, Pocket
from driftform.water import Fluid
from driftform_kit.ballast import FOAM, MATERIALS, PUTTY
from driftform_kit.templates import fill_template
from driftform_kit.trim import displace, fly_cases

ADDED = {**MATERIALS, "epoxy putty": PUTTY}
"""Densities of what can be added outside, kg/m3."""

SCALE = 0.00005
"""Smallest step of a kitchen scale, kg."""

MAX_DEVIATION = 0.2
"""Largest deviation of a net weight, relative to the mass of the agent: more was weighed in air, or in another unit."""


def find_reading(agent: Agent, fluid: Fluid, celsius: float) -> float:
    """Return the net weight (kg) that an agent of the design shows in a bucket of the fluid at a temperature, degrees C."""
    body, volume = agent.body, agent.mass.volume / (1 - agent.body.squeeze)
    warmed = volume * (1 + body.expansion * (celsius - fluid.celsius)) ** 3
    return agent.mass.mass - fluid.density_at(celsius) * warmed


def share_putty(body: Body, missing: float, fluid_density: float, x: float) -> list[tuple[MassElement, Pocket]]:
    """Return the putty that is put into each trim pocket of a body, or negative for what is taken out, with its pocket.

    Together it weighs ``missing`` (kg) under water, or as much of that as the pockets hold; two pockets share it so that it
    balances as near to ``x`` (m) as possible.
    """
    pockets = body.pockets
    rooms = [
        sorted((0.0, MassElement.of_putty(p, float(missing > 0)).mass - MassElement.of_putty(p).mass)) for p in pockets
    ]
    places = [(p.mouth + p.tip) / 2 for p in pockets]
    lacking = [missing / (1 - fluid_density / p.density) for p in pockets]
    if len(pockets) == 2:
        share = (x - places[0]) / (places[1] - places[0])
        first = lacking[0] * min(max(1 - share, 0.0), 1.0)
        # What one has no room for goes into the other.
        first = min(max(first, lacking[0] - rooms[1][1], rooms[0][0]), lacking[0] - rooms[1][0], rooms[0][1])
        lacking = [first, lacking[1] - first]
    masses = [min(max(mass, low), high) for mass, (low, high) in zip(lacking, rooms, strict=True)]
    return [(MassElement(mass, at), p) for mass, at, p in zip(masses, places, pockets, strict=True)]


def trim_in_water(design: Design, net_weight: float, celsius: float | None = None) -> dict[str, Any]:
    """Return what a sealed print lacks by its net weight under water, as ``driftform trim --net-weight --json`` prints it.

    Args:
        net_weight: of the sealed agent, which hangs under water, kg; positive if it sinks.
        celsius: temperature of that water, degrees C; that of the scenario's fluid for ``None``.

    Raises InputError if the net weight cannot be that of this agent, and WorkFailedError if a flight fails.
    """
    agent, fluid = design.agent, design.scenario.fluid
    celsius = fluid.celsius if celsius is None else celsius
    if not -10 <= celsius <= 100:
        raise InputError(f"--water-temperature {celsius:g}: is in degrees C, from -10 to 100")
    wanted, density = find_reading(agent, fluid, celsius), fluid.density_at(celsius)
    missing = wanted - net_weight
    if not (math.isfinite(net_weight) and abs(missing) < MAX_DEVIATION * agent.mass.mass):
        raise InputError(
            f"--net-weight {1000 * net_weight:g}: {design.name} should weigh {1000 * wanted:.2f} g under water, of {1000 * agent.mass.mass:.1f} g "
            "in air: give the grams that the scale shows while the sealed agent hangs under water, negative if it floats"
        )
    off = MassElement.reweigh(agent, (MassElement.of_agent(agent), MassElement(-missing, agent.body.core.cog)))
    changes = share_putty(agent.body, missing, density, float(agent.mass.cog[0])) if abs(missing) >= SCALE / 2 else []
    cases, rest = {"simulated": agent, "untrimmed": off}, missing
    for change, pocket in changes:
        off = MassElement.reweigh(off, (MassElement.of_agent(off), change))
        cases["trimmed"] = off = displace(off, change.mass / pocket.density, change.x)
        rest -= change.mass * (1 - density / pocket.density)
    return {
        "agent": design.name,
        "simulator": design.pipeline.simulator.name,
        "net_weight": net_weight,
        "water_celsius": celsius,
        "water_density": density,
        "wanted_net_weight": wanted,
        "flight_net_weight": agent.mass.mass - fluid.density * agent.mass.volume,
        "flight_celsius": fluid.celsius,
        "missing": missing,
        "pockets": [
            {"end": "fore" if pocket.mouth > pocket.tip else "aft", "x": change.x, "change": change.mass}
            for change, pocket in changes
        ],
        "moved": float(off.mass.cog[0] - agent.mass.cog[0]) if changes else 0.0,
        "rest": rest,
        # What is added displaces water too.
        "added": {
            name: rest / (1 - density / heavy) for name, heavy in ADDED.items() if heavy > density and rest >= SCALE / 2
        },
        "foam": -rest / (density - FOAM) if rest <= -SCALE / 2 else 0.0,
        **fly_cases(design, cases),
    }


def describe_hanging(facts: dict[str, Any], body: Body) -> list[str]:
    """Return what is to be done by the document of :func:`trim_in_water`, one line each."""
    return fill_template("hang.txt", **facts, step=SCALE, core=body.core.cog - float(body.outer[0, 0]))
