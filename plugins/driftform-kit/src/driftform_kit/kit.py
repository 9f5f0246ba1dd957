"""What is known of a kit: its weight with its core, the places of its ballast, and its facts."""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from driftform.agent import mass_properties
from driftform.interfaces import ExportJob
from driftform.types import Body
from driftform_frusta.cores import make_ball
from driftform_frusta.kit_options import KitOptions, PartOptions
from driftform_kit.ballast import name_material
from driftform_kit.cutting.accounting import kit_mass, piece_mass, weigh_kit
from driftform_kit.cutting.coupon import describe_coupon
from driftform_kit.cutting.joint import find_seal
from driftform_kit.cutting.meridian import MM
from driftform_kit.cutting.pieces import Kit, make_kit


@dataclass(frozen=True)
class KitReport:
    """A kit, printed with full flow, with its core: mass (kg), x of its centre of gravity (m), and the ball that it holds, if any.

    Of the ball, as JSON: ``x`` of its centre, its ``diameter``, the ``part`` that holds it, x of the joint that it goes in by (``mouth``) or the
    height at which the printer pauses (``pause``), m, of which one is ``None``, and whether it is ``held_by`` a ``"seat"``, or by
    the ``"wall"`` if the hull narrows there.
    """

    mass: float
    cog: float
    held: tuple[dict[str, Any], ...] = ()


def report_kit(body: Body, options: KitOptions) -> KitReport:
    """Return the weight of the kit of a body, and the places of its ballast.

    Raises WorkFailedError if no kit can be made of the body, or it cannot hold the balls of the options; the
    message has the reason.
    """
    kit, whole = make_kit(body, options), kit_mass(body, options)
    held = tuple(
        {
            "x": ball.ball.z / MM,
            "diameter": 2 * ball.ball.radius / MM,
            "part": kit.pieces[ball.part].name,
            "mouth": None if ball.mouth is None else kit.joints[ball.mouth].z / MM,
            "pause": None if (pause := kit.find_pause(ball)) is None else pause / MM,
            "held_by": "wall" if ball.seat is None else "seat",
        }
        for ball in kit.ballast
    )
    return KitReport(whole.mass, float(whole.cog[0]), held)


def list_facts(job: ExportJob, options: PartOptions) -> dict[str, Any]:
    """Return the facts of a job's kit, under the key ``kit``.

    ``joint``: its ``kind``, where it cuts (``x_mm``), and ``why``. ``seal``: of its O-ring, as :class:`Seal` has it, with ``mass_kg``. ``parts``: of each its ``name``, ``mass_kg``,
    ``height_mm`` and ``bed_end``. ``ballast``: of each ball of the options its ``x_mm`` and ``diameter_mm``, the ``part`` that
    holds it, the joint that it goes in by (``mouth_mm``) or the height at which the printer pauses for it (``pause_mm``),
    ``held_by``: ``seat`` or ``wall``, its ``material`` and its ``mass_kg``. ``balance``: mass (kg), x of the centres of
    gravity and of buoyancy (mm) and net buoyancy (N) of the simulated agent, of the one printed with full flow, and of that
    with its ballast, printed with the flow that the ballast is for (:class:`KitWeight`).
    Of the fit coupon, under ``coupon``, what it is for.
    """
    body = job.agent.body
    if options.coupon:
        return {"coupon": describe_coupon(body, options)}
    kit = make_kit(body, options)
    facts: dict[str, Any] = {
        "joint": {"kind": kit.core_joint.kind, "x_mm": kit.core_joint.z, "why": kit.reason},
        **({"seal": {**asdict(seal), "mass_kg": seal.mass}} if (seal := find_seal(kit.hull, kit.core_joint)) else {}),
        "parts": [
            {
                "name": piece.name,
                "mass_kg": piece_mass(piece, body.hull_density),
                "height_mm": float(np.ptp(piece.mesh.bounds[:, 2])),
                "bed_end": piece.bed_end,
            }
            for piece in kit.pieces
        ],
        "ballast": [
            {
                **{f"{key}_mm": x and MM * x for key, x in ball.items() if key in ("x", "diameter", "mouth", "pause")},
                "part": ball["part"],
                "held_by": ball["held_by"],
                "material": name_material(options.ballast_density),
                "mass_kg": make_ball(options.ballast_density, ball["diameter"]).mass,
            }
            for ball in report_kit(body, options).held
        ],
        "balance": _list_balances(job, kit, options),
    }
    return {"kit": facts}


def _list_balances(job: ExportJob, kit: Kit, options: PartOptions) -> list[dict[str, Any]]:
    printed = kit_mass(job.agent.body, options)
    found = {"simulated": mass_properties(job.agent.body), "printed": printed}
    if (weight := weigh_kit(job.agent, kit, options)).loaded:
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
