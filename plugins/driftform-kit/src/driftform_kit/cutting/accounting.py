"""Mass and volume of a kit, compared with those that were simulated: sleeves, seats and fillings add mass."""

import math
from dataclasses import dataclass, replace
from typing import Any

from driftform.agent import MassElement, mass_properties
from driftform.errors import WorkFailedError
from driftform.types import Agent, Body, Fittings, MassProperties, Moments
from driftform_frusta.cores import make_ball
from driftform_frusta.hull import wall_moments
from driftform_frusta.kit_options import KitOptions, PartOptions
from driftform_kit.ballast import NEGLIGIBLE, ball_diameter
from driftform_kit.cutting.joint import find_seal, seal_start
from driftform_kit.cutting.meridian import MM, moments
from driftform_kit.cutting.pieces import Kit, Piece, make_kit

_ROUNDS = 20
"""Maximum number of balls that are tried, because each changes the mass of its seat."""

_LIGHTER = 0.95
"""Mass of the parts, over that which gives the simulated mass, at which ballast is to make up for the rest."""


def kit_mass(body: Body, options: KitOptions) -> MassProperties:
    """Return mass properties of the assembled kit with its core.

    Ballast, and the putty of trim pockets, are not counted, but seats are. Parts of revolution are integrated in closed form; glue
    weighs nothing here.
    """
    emptied = tuple(replace(pocket, density=0.0) for pocket in body.pockets)
    fittings = measure_fittings(body, options)
    return mass_properties(replace(body, ballast=Moments(), pockets=emptied, fittings=fittings))


def place_ballast(body: Body, options: PartOptions) -> tuple[float, float]:
    """Return x and diameter (m) of the ball that has, with its seat, the mass and the moment of a body's ballast.

    Where such a ball would be in the way of the core, it lies at the place of the ballast, and the seat alone moves the
    centre of gravity, by some tenths of a millimetre at most.

    Raises WorkFailedError if the kit cannot hold it; the message has the reason.
    """
    try:
        return _settle_ball(body, options, True)
    except WorkFailedError:
        return _settle_ball(body, options, False)


def _settle_ball(body: Body, options: PartOptions, balanced: bool) -> tuple[float, float]:
    density, bare = options.ballast_density, kit_mass(body, options)
    mass, x = body.ballast.volume * body.ballast_density, body.ballast.centroid
    lacking, moment, seat = mass, mass * x, 0.0
    for _ in range(_ROUNDS):
        ball = round(moment / lacking if balanced else x, 7), round(ball_diameter(lacking, density), 7)
        seated = kit_mass(body, options.model_copy(update={"ballast": (ball,)}))
        seat = seated.mass - bare.mass
        before, lacking = lacking, mass - seat
        moment = mass * x - float(seated.mass * seated.cog[0] - bare.mass * bare.cog[0])
        if not lacking > 0:
            break
        if abs(lacking - before) < NEGLIGIBLE:
            return ball
    raise WorkFailedError(
        f"no kit can be made: ballast of {1000 * mass:.4g} g is too little for a ball with its seat, which weighs "
        f"{1000 * seat:.2g} g"
    )


@dataclass(frozen=True)
class KitWeight:
    """Weights of the parts of a kit at full flow, and of core, ballast, putty and O-rings, which are bought; kg and kg m.

    The parts may weigh the ``most``, so that the closed kit is not heavier than simulated; it is ``loaded`` with ballast or putty.
    """

    mass: float
    moment: float
    bought: float
    bought_moment: float
    most: float
    loaded: bool

    @property
    def flow(self) -> float:
        """Flow with which the kit and its ballast have the simulated mass, less if ballast is to be added; at most 1."""
        aim = self.most if self.loaded else _LIGHTER * self.most
        return min(1.0, aim / self.mass) if aim > 0 else 1.0

    def closed(self, flow: float) -> tuple[float, float]:
        """Return mass (kg) and moment (kg m) of the closed kit, printed with some flow."""
        return self.bought + flow * self.mass, self.bought_moment + flow * self.moment


def weigh_kit(agent: Agent, kit: Kit, options: PartOptions) -> KitWeight:
    """Return the weights of the parts of an agent's kit, and of what is bought."""
    core, empty = agent.body.core, kit_mass(agent.body, options)
    added = [(make_ball(options.ballast_density, 2 * b.ball.radius / MM).mass, b.ball.z / MM) for b in kit.ballast]
    added += [(putty.mass, putty.x) for putty in map(MassElement.of_putty, agent.body.pockets)]
    rings = _account_for_seals(kit)[0]
    bought = core.mass + sum(mass for mass, _ in added) + rings.volume
    return KitWeight(
        empty.mass - core.mass - rings.volume,
        float(empty.mass * empty.cog[0]) - core.mass * core.cog - rings.first,
        bought,
        sum(mass * x for mass, x in added) + core.mass * core.cog + rings.first,
        agent.mass.mass - bought,
        bool(added),
    )


def measure_fittings(body: Body, options: KitOptions) -> Fittings:
    """Return what a kit has in addition to the wall of a body: joints, seats and fillings, less holes; and its details."""
    details, kit = body.fittings.details, make_kit(body, options)
    fitted = sum((detail.moments for detail in details), wall_moments(body))
    return Fittings(kit_moments(kit) - fitted, details, *_account_for_seals(kit))


def _account_for_seals(kit: Kit) -> tuple[Moments, Moments, tuple[dict[str, Any], ...]]:
    """Return what :class:`Fittings` has of the O-rings of a kit.

    Rims that bear on each other keep no water out. Of what a ring leaves free of its groove, half lies before it.
    """
    rings, flooded, glands = Moments(), Moments(), list[dict[str, Any]]()
    for joint in kit.joints:
        if (gland := joint.gland) and (seal := find_seal(kit.hull, joint)):
            before, radius = seal_start(gland), (seal.groove_mm + gland.depth) / 2
            room = 2 * math.pi * radius * joint.gap * before + seal.volume * (1 / seal.fill - 1) / 2
            rings += _hoop(seal.mass, joint.z - joint.side * (before + gland.width / 2), radius)
            flooded += _hoop(room / MM**3, joint.z - joint.side * before / 2, radius)
            glands.append(seal.describe())
    return rings, flooded, tuple(glands)


def _hoop(amount: float, z: float, radius: float) -> Moments:
    x = z / MM
    return Moments(amount, amount * x, amount * x * x, amount * (radius / MM) ** 2)


def kit_moments(kit: Kit) -> Moments:
    """Return the volume integrals of all parts."""
    return sum(map(_piece_moments, kit.pieces), Moments())


def _piece_moments(piece: Piece) -> Moments:
    return sum((detail.moments for detail in piece.details), moments(piece.rings))


def piece_mass(piece: Piece, density: float) -> float:
    """Return the mass of a part of a material of ``density`` (kg/m3), kg."""
    return density * _piece_moments(piece).volume
