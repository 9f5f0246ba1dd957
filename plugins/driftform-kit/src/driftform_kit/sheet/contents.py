"""Kit -> what its assembly sheet says: parts in the order of assembly, weights, steps."""

from dataclasses import dataclass

import numpy as np

from driftform.interfaces import ExportJob
from driftform.types import MassProperties
from driftform_frusta.cores import CUSTOM, name_core
from driftform_frusta.kit_options import PartOptions
from driftform_kit.ballast import name_material
from driftform_kit.cutting.accounting import KitWeight, held_mass, measure_flooding, piece_mass, weigh_kit
from driftform_kit.cutting.held_ballast import HeldBall
from driftform_kit.cutting.joint import Joint, groove_diameter, takes_core_aft
from driftform_kit.cutting.meridian import MM, Ring
from driftform_kit.cutting.pieces import Kit, Piece, make_kit
from driftform_kit.cutting.upright import needs_brim, overhang_area
from driftform_kit.settings import list_arguments

_LEAST_OVERHANG = 10.0
"""mm2 of overhang that need no mention: a printer bridges them."""

_NBSP = "\u00a0"
"""A space at which no line is broken."""

_ABS = 1050.0
"""Density of ABS, kg/m3, the default of ``builder.hull_density``."""

_SAME_FILAMENT = 0.01
"""Share by which the density of ABS may differ."""

_NEGLIGIBLE = 5e-6
"""kg: half of the last digit of a weight on the sheet."""


@dataclass(frozen=True, eq=False)
class SheetPart:
    """One part on the sheet: its ``number`` in the order of assembly, from 1, its mass (kg), and its overhang (mm2).

    Its ``place`` is that from aft to fore, from 0: the order of colours. What overhangs by more than 45 degrees counts.
    """

    number: int
    place: int
    piece: Piece
    mass: float
    overhang: float

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
    """What an assembly sheet says, with the parts in the order of assembly, and a paragraph for each of the ``steps``.

    Positions are counted from the ``aft`` end, which is given in mm from the core's centre. The parts are to be printed with
    the ``flow``, a share of the full one, with which they weigh what volume and density give; the rows of ``weights`` have a
    mass with either, kg. ``target`` is what was simulated, and the ``remedy`` makes the closed kit weigh and balance like it.
    """

    title: str
    kit: Kit
    parts: tuple[SheetPart, ...]
    core: str
    aft: float
    target: MassProperties
    flow: float
    weights: tuple[tuple[str, float, float], ...]
    remedy: str
    steps: tuple[str, ...]
    settings: tuple[tuple[str, str], ...]


def plan_sheet(job: ExportJob, options: PartOptions, format: str = "stl") -> Sheet:
    """Return the contents of the sheet of a job's kit, which was written in a format."""
    body = job.agent.body
    kit = make_kit(body, options)
    parts = _number_parts(kit, body.hull_density)
    core = f"ball of {2 * MM * body.core.radius:g} mm, {_grams(body.core.mass)}"
    if (name := name_core(body.core)) != CUSTOM:
        core = f"{name}: {core}"
    aft = MM * float(body.outer[0, 0])
    target, printed = job.agent.mass, weigh_kit(job.agent, kit, options)
    balls = [(f"ball {name_mark(held, kit)}", held_mass(held, options)) for held in kit.ballast]
    weights = (
        *((f"{part.number}  {part.piece.name}", part.mass, printed.flow * part.mass) for part in parts),
        *((name, mass, mass) for name, mass in [("core", body.core.mass), *balls]),
        ("closed kit", printed.closed(1.0)[0], printed.closed(printed.flow)[0]),
        ("as simulated", target.mass, target.mass),
    )
    return Sheet(
        title=job.name,
        kit=kit,
        parts=parts,
        core=core,
        aft=aft,
        target=target,
        flow=printed.flow,
        weights=weights,
        remedy=_describe_remedy(target, printed, aft),
        steps=tuple(_Writer(job, kit, parts, core, printed, options, format).list_steps()),
        settings=(
            ("layer height", f"{MM * options.layer_height:g} mm"),
            ("perimeters", f"{options.perimeters}"),
            ("infill", f"{100 * options.infill:g} %"),
            ("nozzle", f"{MM * options.nozzle:g} mm"),
            ("filament", name_filament(body.hull_density)),
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
        SheetPart(number, place, p, piece_mass(p, density), overhang_area(p.rings, p.fore_down))
        for number, (place, p) in enumerate(((place, kit.pieces[place]) for place in order), 1)
    )


def _grams(mass: float) -> str:
    return f"{1000 * mass:.2f}{_NBSP}g"


def name_filament(density: float) -> str:
    """Return what a hull's material of a density (kg/m3) is called: ``ABS, 1.05 g/cm³``, or the density of others."""
    named = "ABS, " if abs(density - _ABS) <= _SAME_FILAMENT * _ABS else ""
    return f"{named}{density / 1000:.4g}{_NBSP}g/cm³"


def name_mark(held: HeldBall, kit: Kit) -> str:
    """Return the letter of a ball of ballast, from aft to fore; parts have numbers."""
    return "AB"[kit.ballast.index(held)]


def _describe_remedy(target: MassProperties, printed: KitWeight, aft: float) -> str:
    """What makes the closed kit weigh and balance as simulated."""

    def place(mass: float, moment: float) -> str:
        return f"{MM * moment / mass - aft:.1f}{_NBSP}mm"

    if printed.most <= 0:
        return (
            f"Core and ballast alone weigh {_grams(-printed.most)} more than the agent as simulated: no flow makes up for "
            "that. Take smaller balls."
        )
    less = f"{100 * (1 - printed.flow):.1f}{_NBSP}% less"
    mass, moment = printed.closed(printed.flow)
    wanted = float(target.mass * target.cog[0])
    lack = target.mass - mass
    if lack >= _NEGLIGIBLE:
        lacking = f"the closed kit lacks {_grams(lack)}, centred at {place(lack, wanted - moment)}"
        start = f"With {less} flow {lacking}" if printed.flow < 1 else lacking.capitalize()
        return f"{start}: add it as ballast, which trim computes from what the print weighs."
    places = place(mass, moment), place(target.mass, wanted)
    balance = f"balances at {places[0]}, " + (
        "as simulated." if places[0] == places[1] else f"and at {places[1]} as simulated."
    )
    if printed.flow > 1 - 5e-4:
        return f"The closed kit weighs what was simulated. It {balance}"
    return (
        f"The ballast is for parts that weigh {_grams(printed.flow * printed.mass)} together, {less} than at full flow. "
        f"With them the closed kit weighs what was simulated, and {balance}"
    )


@dataclass(frozen=True, eq=False)
class _Writer:
    """Writes the steps of an assembly, in an order that can be done: what is closed or glued is not opened again."""

    job: ExportJob
    kit: Kit
    parts: tuple[SheetPart, ...]
    core: str
    printed: KitWeight
    options: PartOptions
    format: str

    @property
    def aft(self) -> float:
        return MM * float(self.job.agent.body.outer[0, 0])

    def list_steps(self) -> list[str]:
        kit, parts, options = self.kit, self.parts, self.options
        body, target = self.job.agent.body, self.job.agent.mass
        by_place = {part.place: part for part in parts}
        enclosed = sorted(
            (held for held in kit.ballast if held.mouth is None), key=lambda held: kit.find_pause(held) or 0
        )
        # Of two balls that go in by one mouth, the deeper one is first.
        inserted = sorted(
            ((kit.joints[held.mouth], held) for held in kit.ballast if held.mouth is not None),
            key=lambda pair: -abs(pair[1].ball.z - pair[0].z),
        )
        numbers = {held: by_place[held.part].number for held in kit.ballast}
        steps = [
            self.describe_printing(),
            *(self.describe_pause(held, numbers[held]) for held in enclosed),
            self.describe_weighing({held: numbers[held] for held in enclosed}),
            self.describe_trim(),
            *(self.describe_insertion(held, numbers[held], mouth) for mouth, held in inserted),
            f"Lay the core ({self.core}) into part 1, the {parts[0].piece.name}. It must reach its seat and not jam.",
        ]
        for part in parts[1:]:
            inward = part.place + (1 if part.place < parts[0].place else -1)
            steps.append(self.describe_joint(kit.joints[min(part.place, inward)], part, by_place[inward]))
        if options.drain:
            steps.append(
                f"Fill or drain through the holes of {MM * options.drain:g} mm at both ends, and plug them flush before "
                f"the launch: the agent was simulated sealed, and an open hole lets in "
                f"{_grams(measure_flooding(kit, body, self.job.scenario.fluid.density))} of water."
            )
        steps.append(
            "Weigh the closed kit, and balance it on an edge. As simulated it weighs "
            f"{_grams(target.mass)} and balances at {MM * float(target.cog[0]) - self.aft:.1f}{_NBSP}mm. Hold it under water: no "
            "bubbles."
        )
        return steps

    def describe_printing(self) -> str:
        flow = ""
        if self.printed.loaded:
            flow = ", and with the flow of the parts that were weighed for the ballast"
        elif self.printed.flow < 1:
            flow = f" and {100 * (1 - self.printed.flow):.1f}{_NBSP}% less flow: mass is easier to add than to remove"
        hanging = [part for part in self.parts if part.overhang > _LEAST_OVERHANG]
        support = "; ".join(f"{part.overhang / 100:.1f} cm² of part {part.number}" for part in hanging)
        text = f"Print the parts upright, as drawn, with the settings below{flow}. " + (
            f"Support: {support} {'overhang' if len(hanging) > 1 else 'overhangs'} by more than 45 degrees."
            if hanging
            else "No support is needed."
        )
        narrow = [
            str(part.number) for part in self.parts if needs_brim(part.piece.rings, part.piece.fore_down)
        ]
        if narrow:
            text += f" Print part {' and '.join(narrow)} with a brim: the foot is small for the height."
        return text

    def describe_weighing(self, enclosed: dict[HeldBall, int]) -> str:
        """How to weigh parts, with the balls in them and their numbers: parts that weigh more than the most need no ballast."""
        text = "Weigh the loose parts and the core, and write down what they weigh."
        for held, number in enclosed.items():
            mass = _grams(held_mass(held, self.options))
            text += f" Take {mass} off part {number} for ball {name_mark(held, self.kit)} inside."
        if self.printed.most <= 0:
            return text
        aim = _grams(self.printed.flow * self.printed.mass)
        most = _grams(self.job.agent.mass.mass - self.job.agent.body.core.mass)
        return (
            f"{text} The parts should weigh {aim} together. If they weigh more than {most}, print them again, with the "
            f"flow times {aim} over what they weigh."
        )

    def describe_trim(self) -> str:
        arguments = f"{self.job.opened_as} {list_arguments([self.format], self.options)}"
        loaded = bool(self.options.ballast)
        text = (
            f"Trim before anything is closed: driftform trim {arguments} --printed-mass KG, where KG is the sum of the loose "
            f"parts and the core in kg{', without ballast' if loaded else ''}; --printed-cog M adds where they balance, if you "
            f"put them together, in m fore of the core's centre, which is at {-self.aft:.1f}{_NBSP}mm. It gives the ballast "
            "and where it goes."
        )
        return text + (" A ball of another size needs another seat: print that part again." if loaded else "")

    def describe_ball(self, held: HeldBall) -> tuple[str, str]:
        """A ball in words, and where it lies."""
        place = "its seat" if held.seat is not None else "the wall that holds it"
        size = f"{name_material(self.options.ballast_density)} ball of {2 * held.ball.radius:.2f}{_NBSP}mm"
        return (
            f"ball {name_mark(held, self.kit)}, a {size}, {_grams(held_mass(held, self.options))}",
            f"{place} at {held.ball.z - self.aft:.1f}{_NBSP}mm, and fix it with a drop of glue",
        )

    def describe_pause(self, held: HeldBall, number: int) -> str:
        ball, where = self.describe_ball(held)
        return (
            f"While part {number} is printed, pause at a height of {self.kit.find_pause(held):.1f}{_NBSP}mm and put in {ball}: "
            f"lay it on {where}."
        )

    def describe_insertion(self, held: HeldBall, number: int, mouth: Joint) -> str:
        ball, where = self.describe_ball(held)
        end = "fore" if mouth.z > held.ball.z else "aft"
        return f"Put {ball}, into part {number} by its {end} end, down to {where}."

    def describe_joint(self, joint: Joint, part: SheetPart, other: SheetPart) -> str:
        place, lap = f"{joint.z - self.aft:.1f}{_NBSP}mm", f"{joint.kind} of {joint.lap:g}{_NBSP}mm"
        text = f"Join part {part.number}, the {part.piece.name}, to part {other.number}, at {place}, by"
        if part.number > 2:
            return f"{text} its {lap}, in the same way."
        # The plug is that of the part on the joint's side.
        plug = max(part, other, key=lambda p: joint.side * p.place)
        if joint.groove:
            seal = (
                f"lay an O-ring of {MM * self.options.o_ring:g}{_NBSP}mm cord into the groove of part {plug.number} (bottom "
                f"{groove_diameter(self.kit.hull, joint):.1f}{_NBSP}mm across) and grease it"
            )
        else:
            seal = f"coat the {joint.kind} of part {plug.number} with glue all round"
        return f"{text} a {lap}: {seal}, and press until the rims touch without a gap."
