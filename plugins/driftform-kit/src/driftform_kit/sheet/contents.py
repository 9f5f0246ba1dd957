"""Kit -> contents of its assembly sheet: parts in the order of assembly, weights, steps."""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from driftform.agent import MassElement
from driftform.interfaces import ExportJob
from driftform.types import MassProperties
from driftform_frusta.cores import CUSTOM, make_ball, name_core
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.materials import MATERIALS, find_material
from driftform_frusta.strength import describe_strength
from driftform_kit.ballast import name_material
from driftform_kit.cutting.accounting import piece_mass, weigh_kit
from driftform_kit.cutting.gland import STRETCH
from driftform_kit.cutting.held_ballast import HeldBall
from driftform_kit.cutting.joint import Joint, find_seal, takes_core_aft
from driftform_kit.cutting.meridian import MM, Ring
from driftform_kit.cutting.pieces import Kit, Piece, make_kit
from driftform_kit.hang import find_reading
from driftform_kit.settings import list_arguments
from driftform_kit.templates import fill_template

_MIN_OVERHANG = 10.0
"""mm2 of overhang that need no mention: a printer bridges them."""

_NBSP = "\u00a0"
"""A space at which no line is broken."""

_NEGLIGIBLE = 5e-6
"""kg: half of the last digit of a weight on the sheet."""


@dataclass(frozen=True, eq=False)
class SheetPart:
    """One part on the sheet: its ``number`` in the order of assembly, from 1, and its mass (kg).

    Its ``place`` is that from aft to fore, from 0: the order of colours.
    """

    number: int
    place: int
    piece: Piece
    mass: float

    @property
    def printed(self) -> tuple[Ring, ...]:
        """Its half section as printed: (r, z) in mm, the bed at z = 0."""
        up = -1.0 if self.piece.fore_down else 1.0
        lowest = min(float((up * ring[:, 1]).min()) for ring in self.piece.rings)
        return tuple(ring * (1.0, up) - (0.0, lowest) for ring in self.piece.rings)

    @property
    def hangs(self) -> bool:
        """Whether its overhang is worth mentioning."""
        return self.piece.overhang > _MIN_OVERHANG

    @property
    def size(self) -> tuple[float, float]:
        """Diameter and height, mm."""
        points = np.concatenate(self.printed)
        return 2 * float(points[:, 0].max()), float(points[:, 1].max())


@dataclass(frozen=True, eq=False)
class SheetBall:
    """A ball of ballast: the letter that marks it, the number of its part, its mass (kg), and how it goes in.

    It goes in by a ``mouth``, or by a pause of the printer at a height of ``pause``, mm.
    """

    mark: str
    number: int
    mass: float
    held: HeldBall
    mouth: Joint | None
    pause: float | None


@dataclass(frozen=True, eq=False)
class Sheet:
    """Contents of an assembly sheet, with the parts in the order of assembly.

    ``steps`` has a paragraph for each, and ``scenes`` the key of its drawing, such as ``join 2``; ``putty`` has the half sections of what is in the pockets. Positions are counted from
    the ``aft`` end, which is given in mm from the core's centre. The parts are to be printed with the ``flow``, a share of the full one, with which they weigh what volume and density give; the rows of ``weights`` have a
    mass with either, kg. ``target`` is what was simulated, and the ``remedy`` makes the closed kit weigh and balance like it.
    """

    title: str
    kit: Kit
    parts: tuple[SheetPart, ...]
    balls: tuple[SheetBall, ...]
    core: str
    aft: float
    target: MassProperties
    flow: float
    weights: tuple[tuple[str, float, float], ...]
    remedy: str
    steps: tuple[str, ...]
    scenes: tuple[str, ...]
    putty: tuple[Ring, ...]
    settings: tuple[tuple[str, str], ...]
    shopping: tuple[tuple[str, str], ...]

    @property
    def bounds(self) -> list[float]:
        """Ends of the parts, from aft to fore, mm from the core's centre."""
        return [self.aft, *(joint.z for joint in self.kit.joints), float(self.kit.hull.skin[-1, 0])]


def plan_sheet(job: ExportJob, options: PartOptions, format: str = "stl") -> Sheet:
    """Return the contents of the sheet of a job's kit, which was written in a format."""
    body, target = job.agent.body, job.agent.mass
    kit = make_kit(body, options)
    parts = _number_parts(kit, body.hull_density)
    balls = tuple(
        SheetBall(
            mark="A",
            number=next(part.number for part in parts if part.place == held.part),
            mass=make_ball(options.ballast_density, 2 * held.ball.radius / MM).mass,
            held=held,
            mouth=None if held.mouth is None else kit.joints[held.mouth],
            pause=kit.find_pause(held),
        )
        for held in kit.ballast
    )
    what = f"capsule of {MM * float(np.ptp(body.core.ends)):g} x" if body.core.contour else "ball of"
    core = f"{what} {2 * MM * body.core.radius:g} mm, {1000 * body.core.mass:.2f}{_NBSP}g"
    if (name := name_core(body.core)) != CUSTOM:
        core = f"{name}: {core}"
    printed, material = weigh_kit(job.agent, kit, options), find_material(body.hull_density)
    filament = f"{material + ', ' if material else ''}{body.hull_density / 1000:.4g}{_NBSP}g/cm³"
    putty = [MassElement.of_putty(pocket) for pocket in body.pockets]
    bought = [("core", body.core.mass), *((f"ball {ball.mark}", ball.mass) for ball in balls)]
    bought += [("putty", sum(element.mass for element in putty))] if putty else []
    seals = {joint: seal for joint in kit.joints if (seal := find_seal(kit.hull, joint))}
    bought += [("O-rings", sum(seal.mass for seal in seals.values()))] if seals else []
    # Keys and paragraphs: the remedy, what to get, and the steps in an order that can be done.
    lines = fill_template(
        "steps.txt",
        nbsp=_NBSP,
        negligible=_NEGLIGIBLE,
        stretch=STRETCH,
        body=body,
        target=target,
        options=options,
        kit=kit,
        parts=parts,
        by_place=sorted(parts, key=lambda part: part.place),
        balls=balls,
        core=core,
        putty=putty,
        aft=MM * float(body.outer[0, 0]),
        printed=printed,
        material=name_material(options.ballast_density),
        filament=filament,
        note=MATERIALS[material].note if material else "",
        seals=seals,
        rings=Counter(replace(seal, groove_mm=round(seal.groove_mm, 1)) for seal in seals.values()),
        readings={c: find_reading(job.agent, job.scenario.fluid, c) for c in (5.0, 10.0, 15.0, 20.0, 25.0)},
        title=job.name,
        opened=job.opened_as,
        arguments=f"{job.opened_as} {list_arguments([format], options)}",
    )
    (_, remedy), *texts = [(key, text) for key, _, text in (line.partition("|") for line in lines)]
    get, strength = "get ", describe_strength(body, job.scenario.fluid)
    hulls = [] if strength is None else [strength]
    return Sheet(
        title=job.name,
        kit=kit,
        parts=parts,
        balls=balls,
        core=core,
        aft=MM * float(body.outer[0, 0]),
        target=target,
        flow=printed.flow,
        weights=(
            *((f"{part.number}  {part.piece.name}", part.mass, printed.flow * part.mass) for part in parts),
            *((name, mass, mass) for name, mass in bought),
            ("closed kit", printed.closed(1.0)[0], printed.closed(printed.flow)[0]),
            ("as simulated", target.mass, target.mass),
        ),
        remedy=remedy,
        putty=tuple(MM * pocket.contour(pocket.filled)[:, ::-1] for pocket in body.pockets),
        steps=tuple(text for key, text in texts if not key.startswith(get)),
        scenes=tuple(key for key, _ in texts if not key.startswith(get)),
        shopping=tuple((key.removeprefix(get), text) for key, text in texts if key.startswith(get)),
        settings=(
            ("layer height", f"{MM * options.layer_height:g} mm"),
            ("perimeters", f"{options.perimeters}"),
            ("infill", f"{100 * options.infill:g} %"),
            ("nozzle", f"{MM * options.nozzle:g} mm"),
            ("filament", filament),
            ("clearance of joints", f"{MM * options.clearance:g} mm"),
            *((d.name, f"{1000 * body.hull_density * d.moments.volume:.2f} g") for d in body.fittings.details),
            *(("withstands", f"{hull['pressure'] / 1e5:.3g} bar ({hull['part']})") for hull in hulls),
            *(("lost per bar", f"{1000 * hull['lost_per_bar']:.2g} g") for hull in hulls),
        ),
    )


def _number_parts(kit: Kit, density: float) -> tuple[SheetPart, ...]:
    """Parts in the order of assembly: the shell that takes the core, the other shell, and then outward."""
    inner = kit.joints.index(kit.core_joint)
    first = inner if takes_core_aft(kit.core_joint) else inner + 1
    order = sorted(range(len(kit.pieces)), key=lambda place: (place != first, abs(place - inner - 0.5), place > inner))
    return tuple(
        SheetPart(number, place, p, piece_mass(p, density))
        for number, (place, p) in enumerate(((place, kit.pieces[place]) for place in order), 1)
    )
