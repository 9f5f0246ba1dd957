"""Kit -> what its assembly sheet says: parts in the order of assembly, weights, steps."""

from dataclasses import dataclass

import numpy as np

from driftform.interfaces import ExportJob
from driftform.types import MassProperties
from driftform_frusta.cores import CUSTOM, name_core
from driftform_frusta.kit.accounting import kit_mass, measure_flooding, piece_mass
from driftform_frusta.kit.ballast import HeldBall
from driftform_frusta.kit.joint import Joint, groove_diameter, takes_core_aft
from driftform_frusta.kit.meridian import MM, Ring
from driftform_frusta.kit.options import PartOptions
from driftform_frusta.kit.pieces import Kit, Piece, make_kit
from driftform_frusta.kit.upright import overhang_area

_LEAST_OVERHANG = 10.0
"""mm2 of overhang that need no mention: a printer bridges them."""

_NBSP = "\u00a0"
"""A space at which no line is broken."""

_NEGLIGIBLE = 5e-6
"""kg: half of the last digit of a weight on the sheet."""


@dataclass(frozen=True, eq=False)
class SheetPart:
    """One part on the sheet.

    Attributes
    ----------
    number
        in the order of assembly, from 1.
    place
        from aft to fore, from 0: the order of colours.
    piece
        the part.
    mass
        kg.
    overhang
        area that overhangs by more than 45 degrees as printed, mm2.
    """

    number: int
    place: int
    piece: Piece
    mass: float
    overhang: float

    @property
    def bed_end(self) -> str:
        """The end that is printed on the bed."""
        return "fore" if self.piece.fore_down else "aft"

    @property
    def printed(self) -> tuple[Ring, ...]:
        """Its half section as printed: (r, z) in mm, the bed at z = 0."""
        up = -1.0 if self.piece.fore_down else 1.0
        lowest = min(float((up * ring[:, 1]).min()) for ring in self.piece.rings)
        return tuple(ring * (1.0, up) - (0.0, lowest) for ring in self.piece.rings)

    @property
    def size(self) -> tuple[float, float]:
        """Diameter and height, mm."""
        points = np.concatenate(self.printed)
        return 2 * float(points[:, 0].max()), float(points[:, 1].max())


@dataclass(frozen=True, eq=False)
class Sheet:
    """What an assembly sheet says.

    Attributes
    ----------
    title
        name of the agent.
    kit
        the kit.
    parts
        in the order of assembly.
    core
        the core, in words.
    aft
        z of the aft end, mm from the core's centre: positions are counted from there.
    target, closed
        mass properties that were simulated, and those of the closed kit.
    weights
        rows of the table: what is weighed, and its mass in kg.
    remedy
        what compensates for the difference of the two.
    steps
        of the assembly, one paragraph each.
    settings
        of the printer: name and value.
    """

    title: str
    kit: Kit
    parts: tuple[SheetPart, ...]
    core: str
    aft: float
    target: MassProperties
    closed: MassProperties
    weights: tuple[tuple[str, float], ...]
    remedy: str
    steps: tuple[str, ...]
    settings: tuple[tuple[str, str], ...]


def plan_sheet(job: ExportJob, options: PartOptions) -> Sheet:
    """Return the contents of the sheet of a job's kit.

    Raises
    ------
    WorkFailedError
        if no kit can be made of the body.
    """
    body = job.agent.body
    kit = make_kit(body, options)
    parts = _number_parts(kit, body.hull_density)
    core = f"ball of {2 * MM * body.core.radius:g} mm, {_grams(body.core.mass)}"
    if (name := name_core(body.core)) != CUSTOM:
        core = f"{name}: {core}"
    aft = MM * float(body.outer[0, 0])
    target, closed = job.agent.mass, kit_mass(body, options)
    weights = (
        *((f"{part.number}  {part.piece.name}", part.mass) for part in parts),
        ("core", body.core.mass),
        ("closed kit", closed.mass),
        ("target, as simulated", target.mass),
    )
    return Sheet(
        title=job.name,
        kit=kit,
        parts=parts,
        core=core,
        aft=aft,
        target=target,
        closed=closed,
        weights=weights,
        remedy=_describe_remedy(target, closed, body.core.mass, aft),
        steps=tuple(_list_steps(job, kit, parts, core, target, options)),
        settings=(
            ("layer height", f"{MM * options.layer_height:g} mm"),
            ("perimeters", f"{options.perimeters}"),
            ("infill", f"{100 * options.infill:g} %"),
            ("nozzle", f"{MM * options.nozzle:g} mm"),
            ("material", f"{body.hull_density:g} kg/m³"),
            ("clearance of joints", f"{MM * options.clearance:g} mm"),
        ),
    )


def _number_parts(kit: Kit, density: float) -> tuple[SheetPart, ...]:
    """Parts in the order of assembly: the shell that takes the core, the other shell, and then outward."""
    inner = kit.joints.index(kit.core_joint.joint)
    first = inner if takes_core_aft(kit.core_joint.joint) else inner + 1
    order = sorted(
        range(len(kit.pieces)), key=lambda place: (place != first, abs(place - inner - 0.5), place > inner)
    )
    return tuple(
        SheetPart(
            number,
            place,
            kit.pieces[place],
            piece_mass(kit.pieces[place], density),
            overhang_area(kit.pieces[place].rings, kit.pieces[place].fore_down),
        )
        for number, place in enumerate(order, 1)
    )


def _grams(mass: float) -> str:
    return f"{1000 * mass:.2f}{_NBSP}g"


def _describe_remedy(target: MassProperties, closed: MassProperties, core: float, aft: float) -> str:
    lack = target.mass - closed.mass
    places = [f"{MM * float(mass.cog[0]) - aft:.1f}{_NBSP}mm" for mass in (closed, target)]
    balance = f"It balances {places[0]} from the aft end, as simulated {places[1]}."
    if abs(lack) < _NEGLIGIBLE:
        return f"The closed kit weighs what was simulated. {balance}"
    if lack < 0:
        share = 100 * -lack / (closed.mass - core)
        return (
            f"The closed kit is {_grams(-lack)} too heavy. {balance} Print it with {share:.1f}{_NBSP}% less flow or still "
            "less, and add the rest as ballast: mass is easier to add than to remove."
        )
    x = MM * float(target.mass * target.cog[0] - closed.mass * closed.cog[0]) / lack - aft
    return (
        f"The closed kit without ballast is {_grams(lack)} too light. {balance} Add that mass as ballast, centred "
        f"{x:.1f}{_NBSP}mm from the aft end."
    )


def _list_steps(
    job: ExportJob,
    kit: Kit,
    parts: tuple[SheetPart, ...],
    core: str,
    target: MassProperties,
    options: PartOptions,
) -> list[str]:
    body = job.agent.body
    aft = MM * float(body.outer[0, 0])
    hanging = [part for part in parts if part.overhang > _LEAST_OVERHANG]
    support = "; ".join(f"{part.overhang / 100:.1f} cm² of part {part.number}" for part in hanging)
    printing = "Print the parts upright, as drawn, with the settings below"
    steps = [
        f"{printing}. Support: {support} {'overhang' if len(hanging) > 1 else 'overhangs'} by more than 45 degrees."
        if hanging
        else f"{printing}. No support is needed.",
        "Weigh the parts and the core, and write down what they weigh. If the parts are off by a share of their mass, print "
        "them again with the flow changed by that share.",
    ]
    by_place = {part.place: part for part in parts}
    for part in parts:
        steps += [_describe_ballast(held, part, kit, aft) for held in kit.ballast if held.part == part.place]
        if part.number == 1:
            steps.append(
                f"Lay the core ({core}) into part 1, the {part.piece.name}. It must reach its seat and not jam."
            )
            continue
        inward = part.place + (1 if part.place < parts[0].place else -1)
        joint = kit.joints[min(part.place, inward)]
        steps.append(_describe_joint(joint, part, by_place[inward], kit, aft, options))
    if options.drain:
        steps.append(
            f"Fill or drain through the holes of {MM * options.drain:g} mm at both ends, and plug them flush before "
            f"the launch: the agent was simulated sealed, and an open hole lets in "
            f"{_grams(measure_flooding(kit, body, job.scenario.fluid.density))} of water."
        )
    steps.append(
        "Weigh the closed kit, and balance it on an edge. As simulated it weighs "
        f"{_grams(target.mass)} and balances {MM * float(target.cog[0]) - aft:.1f} mm from the aft end."
    )
    steps.append(
        "Trim: driftform trim AGENT --kit --printed-mass KG (and --printed-cog M, from the core's centre) gives the "
        "ballast, where it goes, and the flights with and without it. Then hold the agent under water: no bubbles."
    )
    return steps


def _describe_ballast(held: HeldBall, part: SheetPart, kit: Kit, aft: float) -> str:
    ball = f"the ballast, a ball of {2 * held.ball.radius:.1f}{_NBSP}mm"
    place = "its seat" if held.seat is not None else "the wall that holds it"
    where = f"{place} {held.ball.z - aft:.1f}{_NBSP}mm from the aft end, and fix it with a drop of glue"
    pause = kit.find_pause(held)
    if pause is not None:
        return (
            f"Part {part.number} has {ball}, put in while it is printed: pause at a height of {pause:.1f}{_NBSP}mm, lay the "
            f"ball on {where}."
        )
    assert held.mouth is not None
    end = "fore" if kit.joints[held.mouth].z > held.ball.z else "aft"
    return f"Put {ball}, into part {part.number} by its {end} end, down to {where}."


def _describe_joint(
    joint: Joint, part: SheetPart, other: SheetPart, kit: Kit, aft: float, options: PartOptions
) -> str:
    where = f"{joint.z - aft:.1f}{_NBSP}mm from the aft end"
    what = f"part {part.number}, the {part.piece.name}, to part {other.number}"
    if part.number > 2:
        return f"Join {what}, {where}, by its {joint.kind} of {joint.lap:g}{_NBSP}mm, in the same way."
    # The plug is that of the part on the joint's side.
    plug = max(part, other, key=lambda p: joint.side * p.place)
    if joint.groove:
        seal = (
            f"lay an O-ring of {MM * options.o_ring:g}{_NBSP}mm cord into the groove of part {plug.number} (bottom "
            f"{groove_diameter(kit.hull, joint):.1f}{_NBSP}mm across) and grease it"
        )
    else:
        seal = f"coat the {joint.kind} of part {plug.number} with glue all round"
    return (
        f"Join {what}, {where}, by a {joint.kind} of {joint.lap:g}{_NBSP}mm: {seal}, and press until the rims touch "
        "without a gap."
    )
