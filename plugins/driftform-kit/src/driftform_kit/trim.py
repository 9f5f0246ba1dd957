"""Trim: the ballast that makes a weighed print fly as simulated, and its flight without."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from driftform import Design
from driftform.agent import MassElement
from driftform.cli import formats
from driftform.errors import InputError, WorkFailedError
from driftform.motion import path
from driftform.types import Agent, FloatArray
from driftform_frusta.kit_options import STEEL, PartOptions
from driftform_frusta.parts import settle_ballast
from driftform_kit import ballast
from driftform_kit.ballast import NEGLIGIBLE, Piece
from driftform_kit.kit import KitReport, report_kit

GRAMS_FOR_KG = 20
"""A printed mass of more than this many times the simulated one was given in another unit."""

_ROUNDS = 16
"""Maximum number of times that ballast is placed, because each place changes the mass of its seats."""

_SETTLED = 2e-4
"""Relative change of the ballast by its seats that is left; 0.05 mm at a quarter of a metre."""

_SAME_SIZE = 0.1
"""Share of its diameter by which a ball may differ from that of its seat: it then lies within a twentieth of it."""


Balls = Sequence[tuple[float, float]]
"""Of each ball x and diameter, m."""

MeasureKit = Callable[[Balls | None], KitReport]
"""Measures a kit with seats for balls, for ``None`` with those of its options; fails if it cannot hold them."""


@dataclass(frozen=True)
class PrintWeight:
    """The mass of a print with its core, kg, and x of their centre of gravity, m; ``None`` for that of the hull's material.

    The ``source`` of x is ``"measured"``, ``"hull"`` or ``"kit"``.
    """

    mass: float
    cog: float | None
    source: str

    def elements(self, agent: Agent) -> tuple[MassElement, ...]:
        """Return the hull and the core of a print of an agent, and the putty of its trim pockets, which is not weighed."""
        putty = map(MassElement.of_putty, agent.body.pockets)
        return (*MassElement.of_print(agent.body, self.mass, self.cog), *putty)


def weigh_print(agent: Agent, mass: float | None, cog: float | None, kit: KitReport | None = None) -> PrintWeight:
    """Return the weight of a print, from its measurements (kg, m; ``None`` if missing) and its kit.

    Raises InputError if the mass is missing.
    """
    core, moment = agent.body.core.mass, agent.body.core.mass * agent.body.core.cog
    if mass is None and (kit is None or cog is not None):
        raise InputError("--printed-mass is missing: weigh the print with its core in, kg")
    if mass is not None and (cog is not None or kit is None or mass <= core):
        return PrintWeight(mass, cog, "hull" if cog is None else "measured")
    assert kit is not None
    if mass is None:
        return PrintWeight(kit.mass, kit.cog, "kit")
    # The core's mass and place are known: the difference is spread as the parts of the kit are.
    hull = (kit.mass * kit.cog - moment) / (kit.mass - core)
    return PrintWeight(mass, (mass - core) / mass * hull + moment / mass, "kit")


def _trim(design: Design, weight: PrintWeight, density: float, measure: MeasureKit | None) -> dict[str, Any]:
    """Plan the ballast of some density (kg/m3), and fly the agent with and without it; ``measure`` is ``None`` without a kit."""
    pipeline, agent, name = design.pipeline, design.agent, design.name
    _check(agent, name, weight, density)
    water = pipeline.scenario.fluid.density
    plan = _Planner(agent, weight, density, measure).plan(water)
    trimmed, remedy = _load(agent, plan, water)
    printed = MassElement.reweigh(agent, weight.elements(agent))
    agents = {"simulated": agent, "untrimmed": printed} | ({"trimmed": trimmed} if trimmed else {})
    return {
        "agent": name,
        "simulator": pipeline.simulator.name,
        "simulated_mass": agent.mass.mass,
        "simulated_cog": agent.mass.cog[0],
        "printed_mass": weight.mass,
        "printed_cog": printed.mass.cog[0],
        "cog_source": weight.source,
        "aft_end": agent.body.outer[:, 0].min(),
        "ballast_mass": plan.required.mass,
        "ballast_x": plan.required.x if abs(plan.required.mass) >= NEGLIGIBLE else None,
        "ballast_density": density,
        **remedy,
        **fly_cases(design, agents),
    }


def fly_cases(design: Design, agents: dict[str, Agent]) -> dict[str, Any]:
    """Fly the same agent ``simulated``, ``untrimmed`` and ``trimmed``, if it is there, and return fitness, misses and ends by case."""
    pipeline = design.pipeline
    flights = dict(zip(agents, pipeline.fly_named(list(agents.values()), design.name), strict=True))
    targets, points = pipeline.scenario.target_names, pipeline.scenario.target_array()
    scores = {
        case: dict(zip(targets, pipeline.score(flight, agents[case]), strict=True))
        for case, flight in flights.items()
        if flight.failure is None
    }
    closest = {case: path.closest_approach(flight, points)[0] for case, flight in flights.items()}
    return {
        **{case: scores.get(case) for case in ("simulated", "untrimmed", "trimmed")},
        "misses": {case: dict(zip(targets, closest[case], strict=True)) for case in scores},
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
        hull = (mass * x - body.core.mass * body.core.cog) / (mass - body.core.mass)
        if not aft < hull < fore:
            raise InputError(
                f"--printed-cog {x:g}: with its core at x {body.core.cog:.4g}, the hull alone would balance at x {hull:.4f} m, outside the "
                f"body ({aft:.4f} to {fore:.4f} m); weigh and balance it with its core in"
            )
    if not 1 < density < 1e5:
        raise InputError(f"--ballast-density {density:g}: should be a density in kg/m3, such as 11340 for lead")


@dataclass(frozen=True)
class _Plan:
    """Ballast for a print: its weight with the seats, what it lacks then, and pieces, if any are needed and have room.

    The kit holds the balls ``held``, or none of them, and why is ``unheld``; seats of the mass ``seats`` (kg) are to be
    printed for them yet. Its own seats are for the balls ``misfits``, if they do not fit what is needed.
    """

    weight: PrintWeight
    required: MassElement
    pieces: tuple[Piece, ...] = ()
    held: tuple[dict[str, Any], ...] = ()
    seats: float = 0.0
    unheld: str = ""
    misfits: tuple[dict[str, Any], ...] = ()


@dataclass(frozen=True)
class _Planner:
    agent: Agent
    weight: PrintWeight
    density: float
    measure: MeasureKit | None

    def plan(self, water: float) -> _Plan:
        """Return the ballast for a print in water of some density, kg/m3."""
        body, required, density = self.agent.body, self.find_required(self.weight), self.density
        if required.mass < NEGLIGIBLE:
            return _Plan(self.weight, required)
        if density <= water:
            raise InputError(f"--ballast-density {density:g}: must be more than that of the water, {water:g} kg/m3")
        if self.measure is None:
            return _Plan(self.weight, required, ballast.place_by_hand(body, required, density))
        kit = self.measure(None)
        for seat in kit.held:
            filled = ballast.make_ball(required.mass, seat["x"], density)
            if abs((filled.diameter or 0.0) - seat["diameter"]) <= _SAME_SIZE * seat["diameter"]:
                return _Plan(self.weight, required, (filled,), kit.held)
        unheld, plan = "no ball has room where it is needed", None
        try:
            # A seat weighs too.
            plan = self.settle(kit, self.measure)
        except WorkFailedError as error:
            unheld = str(error)
        plan = plan or _Plan(
            self.weight, required, ballast.place_by_hand(self.agent.body, required, density), unheld=unheld
        )
        # A seat that holds nothing is in the way of what is put in by hand.
        return replace(plan, misfits=kit.held, pieces=() if kit.held and not plan.held else plan.pieces)

    def find_required(self, weight: PrintWeight) -> MassElement:
        return ballast.required_ballast(
            self.agent.mass, MassElement.reweigh(self.agent, weight.elements(self.agent)).mass
        )

    def settle(self, kit: KitReport, measure: MeasureKit) -> _Plan | None:
        """Repeat until the ballast is that of a print with the seat for it; ``None`` if no ball has room."""
        core = self.agent.body.core.mass
        # The seats are printed as the rest of the hull was.
        flow = (self.weight.mass - core) / (kit.mass - core)
        assumed = np.zeros(2)  # mass and moment of the seats
        for _ in range(_ROUNDS):
            required = self.find_required(self.add(assumed))
            pieces = ballast.place_one_ball(self.agent.body, required, self.density)
            if not pieces and assumed[0]:
                raise WorkFailedError(
                    f"with the mass of a seat, {1000 * assumed[0]:.2f} g, no ball has room where it is needed"
                )
            if not pieces:
                return None
            made = measure([(round(p.element.x, 5), round(p.diameter or 0.0, 5)) for p in pieces])
            seats = flow * np.array([made.mass - kit.mass, made.mass * made.cog - kit.mass * kit.cog])
            off = np.abs(seats - assumed)
            if off[0] < _SETTLED * required.mass and off[1] < _SETTLED * abs(required.mass * required.x):
                seated = self.add(seats)
                return _Plan(seated, self.find_required(seated), pieces, made.held, float(seats[0]))
            # A heavier seat makes the ballast smaller, and that the seat lighter: the mean comes to rest.
            assumed = (assumed + seats) / 2
        raise WorkFailedError(f"the mass of its seat, about {1000 * assumed[0]:.2f} g, depends too much on its place")

    def add(self, seats: FloatArray) -> PrintWeight:
        elements = MassElement.of_print(self.agent.body, self.weight.mass, self.weight.cog)
        printed = MassElement.reweigh(self.agent, elements).mass
        whole = self.weight.mass + seats[0]
        cog = (printed.mass * printed.cog[0] + seats[1]) / whole
        return PrintWeight(float(whole), float(cog), self.weight.source)


def _load(agent: Agent, plan: _Plan, water: float) -> tuple[Agent | None, dict[str, Any]]:
    """The agent with its ballast or buoyancy, ``None`` without room for it, and what that is."""
    hull, *others = plan.weight.elements(agent)
    elements, required = [hull, *others, *(piece.element for piece in plan.pieces)], plan.required
    trimmed = buoyancy = residual = None
    if required.mass <= -NEGLIGIBLE:
        trimmed, buoyancy = _lift(agent, elements, required, water)
        buoyancy["hull_excess"] = -required.mass / hull.mass
    elif plan.pieces or required.mass < NEGLIGIBLE:
        trimmed = MassElement.reweigh(agent, elements)
        residual = trimmed.mass.mass * trimmed.mass.cog[0] - agent.mass.mass * agent.mass.cog[0]
    return trimmed, {
        "pieces": [
            {
                "mass": piece.element.mass,
                "x": piece.element.x,
                **{key: value for key, value in vars(piece).items() if key != "element"},
            }
            for piece in plan.pieces
        ],
        "held": plan.held,
        "misfits": plan.misfits,
        "seat_mass": plan.seats,
        "unheld": plan.unheld or None,
        "residual_moment": residual,
        "buoyancy": buoyancy,
    }


def _lift(
    agent: Agent, elements: Sequence[MassElement], required: MassElement, water: float
) -> tuple[Agent, dict[str, Any]]:
    """With foam on the outside that carries the excess weight; the water does not feel its shape."""
    volume = -required.mass / (water - ballast.FOAM)
    aft, fore = agent.body.outer[0, 0], agent.body.outer[-1, 0]
    x = float(np.clip(required.x, aft, fore))
    loaded = MassElement.reweigh(agent, [*elements, MassElement(ballast.FOAM * volume, x)])
    return displace(loaded, volume, x), {"volume": volume, "density": ballast.FOAM, "x": x}


def displace(agent: Agent, volume: float, x: float) -> Agent:
    """Return an agent that displaces so much more (m3) at x (m)."""
    displaced = agent.mass.volume + volume
    cob = (agent.mass.volume * agent.mass.cob[0] + volume * x) / displaced
    return replace(agent, mass=replace(agent.mass, volume=displaced, cob=np.array([cob, 0.0, 0.0])))


def trim_design(
    design: Design,
    printed_mass: float | None = None,
    printed_cog: float | None = None,
    *,
    kit: bool = False,
    format: str = "stl",
    ballast_density: float | None = None,
) -> dict[str, Any]:
    """Return the ballast that makes the print fly as simulated, as ``driftform trim --json`` prints it.

    Args:
        printed_mass: what the print weighs with its core, kg; with ``kit``, ``None`` for what its parts should weigh.
        printed_cog: x of its centre of gravity from the core's centre, fore positive, m; ``None`` if it was not
            measured.
        kit: whether it is printed as a kit: its sleeves and seats weigh too.
        format: name of the exporter whose options the kit has.
        ballast_density: kg/m3; ``None`` for that of the kit's options, or else of steel.

    Raises InputError if a value cannot be that of this agent, and WorkFailedError if a flight fails.
    """
    if not kit:
        weight = weigh_print(design.agent, printed_mass, printed_cog)
        return _trim(design, weight, STEEL if ballast_density is None else ballast_density, None)
    kit_settings = formats.list_exporter_settings([format], {"kit": ("true", "--kit")})
    exporter, body = design.under(*kit_settings).study.make_exporter(format), design.agent.body
    given = exporter.options
    if not isinstance(given, PartOptions):
        raise WorkFailedError(
            f"exporter '{format}' does not report how its kit balances; weigh the kit, and leave --kit out"
        )
    given = settle_ballast(body, given)
    if ballast_density is None:
        ballast_density = given.ballast_density

    def measure(balls: Balls | None = None) -> KitReport:
        return report_kit(body, given if balls is None else given.model_copy(update={"ballast": tuple(balls)}))

    weight = weigh_print(design.agent, printed_mass, printed_cog, measure())
    return _trim(design, weight, ballast_density, measure)
