"""Mass and volume of a kit, compared with those that were simulated: sleeves, seats and fillings add mass."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from driftform.agent import mass_properties, solid_of_revolution
from driftform.errors import WorkFailedError
from driftform.interfaces import ExportJob
from driftform.types import Agent, Body, Fittings, FloatArray, MassProperties, Moments
from driftform_frusta.kit_options import KitOptions, PartOptions
from driftform_kit.ballast import NEGLIGIBLE, ball_diameter, ball_mass, name_material
from driftform_kit.cutting.coupon import describe_coupon
from driftform_kit.cutting.engraving import Engraving
from driftform_kit.cutting.held_ballast import HeldBall
from driftform_kit.cutting.meridian import MM, moments
from driftform_kit.cutting.pieces import Kit, Piece, make_kit

_ROUNDS = 20
"""Maximum number of balls that are tried, because each changes the mass of its seat."""

_LIGHTER = 0.95
"""Mass of the parts, over that which gives the simulated mass, at which ballast is to make up for the rest."""


def kit_mass(body: Body, options: KitOptions) -> MassProperties:
    """Return mass properties of the assembled kit with its core.

    Ballast is not counted, but its seats are. Parts of revolution are integrated in closed form; glue and O-rings weigh nothing here, and holes of ``drain``
    are taken to be plugged flush. An engraving is taken out as a point mass, which is exact but for the inertia, and
    outside it fills with water.
    """
    kit = make_kit(body, options)
    whole = mass_properties(replace(body, ballast=Moments()), kit_moments(kit))
    outside = options.engrave_side == "outside"
    for text in kit.engravings:
        whole = _subtract(whole, text, body.hull_density, outside)
    return whole


def held_mass(held: HeldBall, options: PartOptions) -> float:
    """Return the mass of a ball of ballast, kg."""
    return ball_mass(2 * held.ball.radius / MM, options.ballast_density)


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
    """Weights of the parts of a kit at full flow, and of core and ballast, which are bought; kg and kg m.

    The parts may weigh the ``most``, so that the closed kit is not heavier than simulated; it is ``loaded`` with ballast.
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
    """Return the weights of the parts of an agent's kit, of its core and of its ballast."""
    core, empty = agent.body.core, kit_mass(agent.body, options)
    balls = [(held_mass(held, options), held.ball.z / MM) for held in kit.ballast]
    bought = core.mass + sum(mass for mass, _ in balls)
    return KitWeight(
        empty.mass - core.mass,
        float(empty.mass * empty.cog[0]) - core.mass * core.cog,
        bought,
        sum(mass * x for mass, x in balls) + core.mass * core.cog,
        agent.mass.mass - bought,
        bool(balls),
    )


def measure_fittings(body: Body, options: KitOptions) -> Fittings:
    """Return what a kit has in addition to the wall of a body: joints, seats and fillings, less holes and engravings.

    With these fittings :func:`driftform.agent.mass_properties` of the body are :func:`kit_mass`, but for the distance
    of the centre of gravity from the axis: an engraving on one side moves it by micrometres, and a body of revolution
    has it on the axis.
    """
    kit = make_kit(body, options)
    removed = sum((_point_moments(text) for text in kit.engravings), Moments())
    wall = solid_of_revolution(body.outer) - solid_of_revolution(body.cavity)
    flooded = removed if options.engrave_side == "outside" else Moments()
    return Fittings(kit_moments(kit) - wall - removed, Moments() - flooded)


def kit_moments(kit: Kit) -> Moments:
    """Return the volume integrals of all parts, without engravings."""
    return sum((moments(piece.rings) for piece in kit.pieces), Moments())


def _point_moments(text: Engraving) -> Moments:
    x, y, z = text.centroid.tolist()
    return Moments(text.volume, text.volume * x, text.volume * x**2, text.volume * (y**2 + z**2))


def _subtract(whole: MassProperties, text: Engraving, density: float, floods: bool) -> MassProperties:
    lost = text.volume * density
    mass = whole.mass - lost
    cog = (whole.mass * whole.cog - lost * text.centroid) / mass
    inertia = (
        whole.inertia
        + whole.mass * _point_inertia(whole.cog)
        - lost * _point_inertia(text.centroid)
        - mass * _point_inertia(cog)
    )
    if not floods:
        return MassProperties(mass, cog, inertia, whole.volume, whole.cob)
    volume = whole.volume - text.volume
    cob = (whole.volume * whole.cob - text.volume * text.centroid) / volume
    return MassProperties(mass, cog, inertia, volume, cob)


def _point_inertia(at: FloatArray) -> FloatArray:
    square: FloatArray = float(at @ at) * np.eye(3) - np.outer(at, at)
    return square


def list_facts(job: ExportJob, options: PartOptions) -> dict[str, Any]:
    """Return the facts of a job's kit, under the key ``kit``.

    ``joint``: its ``kind``, where it cuts (``x_mm``), and ``why``. ``parts``: of each its ``name``, ``mass_kg``,
    ``height_mm`` and ``bed_end``. ``ballast``: of each ball of the options its ``x_mm`` and ``diameter_mm``, the ``part`` that
    holds it, the joint that it goes in by (``mouth_mm``) or the height at which the printer pauses for it (``pause_mm``),
    ``held_by``: ``seat`` or ``wall``, its ``material`` and its ``mass_kg``. ``balance``: mass (kg), x of the centres of
    gravity and of buoyancy (mm) and net buoyancy (N) of the simulated agent, of the one printed with full flow, and of that
    with its ballast, printed with the flow that the ballast is for (:class:`KitWeight`). With holes also ``flooded_kg``, the mass of the
    water that enters through an open hole. Of the fit coupon, under ``coupon``, what it is for.
    """
    body = job.agent.body
    if options.coupon:
        return {"coupon": describe_coupon(body, options)}
    kit = make_kit(body, options)
    facts: dict[str, Any] = {
        "joint": {"kind": kit.core_joint.kind, "x_mm": kit.core_joint.z, "why": kit.reason},
        "parts": [
            {
                "name": piece.name,
                "mass_kg": piece_mass(piece, body.hull_density),
                "height_mm": float(np.ptp(np.concatenate(piece.rings)[:, 1])),
                "bed_end": piece.bed_end,
            }
            for piece in kit.pieces
        ],
        "ballast": [
            {
                "x_mm": held.ball.z,
                "diameter_mm": 2 * held.ball.radius,
                "part": kit.pieces[held.part].name,
                "mouth_mm": None if held.mouth is None else kit.joints[held.mouth].z,
                "pause_mm": kit.find_pause(held),
                "held_by": "wall" if held.seat is None else "seat",
                "material": name_material(options.ballast_density),
                "mass_kg": held_mass(held, options),
            }
            for held in kit.ballast
        ],
        "balance": _list_balances(job, kit, options),
    }
    if options.drain:
        facts["flooded_kg"] = measure_flooding(kit, body, job.scenario.fluid.density)
    return {"kit": facts}


def _list_balances(job: ExportJob, kit: Kit, options: PartOptions) -> list[dict[str, Any]]:
    printed = kit_mass(job.agent.body, options)
    found = {"simulated": mass_properties(job.agent.body), "printed": printed}
    if kit.ballast:
        weight = weigh_kit(job.agent, kit, options)
        total, moment = weight.closed(weight.flow)
        found["with ballast"] = replace(printed, mass=total, cog=np.array([moment / total, 0.0, 0.0]))
    return [
        {
            "of": name,
            "mass_kg": mass.mass,
            "cog_mm": MM * float(mass.cog[0]),
            "cob_mm": MM * float(mass.cob[0]),
            "net_buoyancy_n": mass.net_buoyancy(job.scenario.fluid),
        }
        for name, mass in found.items()
    ]


def piece_mass(piece: Piece, density: float) -> float:
    """Return the mass of a part of a material of ``density`` (kg/m3), kg."""
    return density * (moments(piece.rings).volume - (piece.engraved.volume if piece.engraved else 0.0))


def measure_flooding(kit: Kit, body: Body, water: float) -> float:
    """Return the mass of the water (density in kg/m3) that fills the closed kit through an open hole, kg."""
    inside = solid_of_revolution(body.outer).volume - kit_moments(kit).volume
    return water * (inside - body.core.volume)
