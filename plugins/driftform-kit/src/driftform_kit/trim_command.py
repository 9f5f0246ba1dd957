"""``driftform trim``."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from driftform.cli import options

if TYPE_CHECKING:
    from driftform.interfaces import Fitness, Table
    from driftform_kit.trim import Balls


_NO_MOMENT = 1e-9
"""Moment of ballast that counts as zero, kg m: a thousandth of a gram millimetre."""

_NEAR = 5e-5
"""m: ballast lies where it should if it is off by less than this; nobody can lay it more accurately."""


def trim(
    agent: options.Agent,
    printed_mass: Annotated[
        float | None,
        typer.Option(
            metavar="KG",
            help="Mass of the print with its core and without ballast, kg; with --kit by default that of its parts.",
        ),
    ] = None,
    printed_cog: Annotated[
        float | None,
        typer.Option(
            metavar="M",
            help="x of its centre of gravity from the core's centre, fore positive, m; by default that of the "
            "hull's material.",
        ),
    ] = None,
    kit: Annotated[
        bool,
        typer.Option(
            "--kit",
            help="Count the sleeves and seats of the kit; give --format, --bed and --option as 'driftform export' has them.",
        ),
    ] = False,
    format: Annotated[
        str, typer.Option(metavar="NAME[,NAME...]", help="Formats that the kit is exported to.")
    ] = "stl",
    bed: options.Bed = None,
    option: options.ExporterOptions = None,
    ballast_density: Annotated[
        float | None,
        typer.Option(
            metavar="KG/M3",
            help="Density of the ballast, kg/m3; by default that of the kit's options, or of lead, 11340.",
        ),
    ] = None,
    scenario: options.ScenarioOption = None,
    simulator: options.Simulator = None,
    hydrodynamics: options.Hydrodynamics = None,
    settings: options.Settings = None,
    json: options.Json = False,
) -> None:
    """Compute the ballast that makes a print fly as simulated, and show its path without it."""
    from driftform.cli import formats, output
    from driftform.errors import InputError
    from driftform_kit.trim import trim_design

    names = formats.parse_formats(format, "exporter", "stl")
    for name, given in (("format", names != ["stl"]), ("bed", bed), ("option", option)):
        if given and not kit:
            raise InputError(f"--{name}: goes with --kit")
    use = {"simulator": simulator, "hydrodynamics": hydrodynamics}
    design = formats.open_exported(agent, names, kit, bed, option or (), settings or (), scenario, use)
    facts = trim_design(
        design, printed_mass, printed_cog, kit=kit, format=names[0], ballast_density=ballast_density
    )
    if json:
        output.print_json(facts)
        return
    exporter = design.study.make_exporter(names[0])
    kept = [setting for setting in settings or () if not setting.lstrip().startswith("exporter.")]
    again = {"scenario": scenario, **use}
    command = _Command(
        shlex.join([agent, *(word for setting in kept for word in ("--set", setting))]),
        names,
        exporter.options,
        shlex.join(word for key, value in again.items() if value for word in (f"--{key}", value)),
    )
    _print(facts, design.pipeline.fitness, command)


@dataclass(frozen=True)
class _Command:
    """What the commands that are printed have in common.

    Attributes
    ----------
    agent
        with its settings.
    formats
        names of exporters.
    options
        of the first of them.
    flight
        arguments of the flight.
    """

    agent: str
    formats: Sequence[str]
    options: "Table"
    flight: str

    def write(self, ballast: "Balls", density: float) -> tuple[str, str]:
        """Return the commands that export the kit with ballast, and trim it then."""
        from driftform_kit.ballast import MATERIALS, name_material
        from driftform_kit.settings import list_arguments

        changed: dict[str, Any] = {"ballast": ballast}
        if name_material(density) != name_material(MATERIALS["lead"]):
            changed["ballast_density"] = density
        arguments = f"{self.agent} {list_arguments(self.formats, self.options.model_copy(update=changed))}"
        trim = f"driftform trim {arguments} --printed-mass KG {self.flight}"
        return f"driftform export {arguments}", trim.rstrip()


def _print(facts: dict[str, Any], fitness: "Fitness[Any]", command: _Command) -> None:
    from driftform.cli import output

    aft = facts["aft_end"]

    def place(x: float) -> str:
        return f"x {1000 * x:+.2f} mm, {1000 * (x - aft):.2f} mm from the aft end"

    source = {
        "measured": "",
        "hull": "; not measured: where the hull's material has it",
        "kit": "; not measured: where the parts of the kit have it",
    }[facts["cog_source"]]
    rows = [
        ("simulated", f"{1000 * facts['simulated_mass']:.3f} g", place(facts["simulated_cog"])),
        ("printed", f"{1000 * facts['printed_mass']:.3f} g", place(facts["printed_cog"]) + source),
    ]
    output.print_table(("", "mass", "centre of gravity"), rows, right=(1,))
    print()
    for line in _remedy(facts, place, command):
        print(line)
    print(f"\n{fitness.heading}")
    names = [name for name in ("simulated", "untrimmed", "trimmed") if name in facts["ends"]]
    # A failed flight costs its column, not the others.
    columns = {name: facts[name] or {} for name in names}
    targets = list(dict.fromkeys(target for column in columns.values() for target in column))
    output.print_table(
        ("target", *names),
        (
            (
                target,
                *(
                    f"{fitness.measure(columns[name][target]):.3f}" if columns[name] else "-"
                    for name in names
                ),
            )
            for target in targets
        ),
        right=range(1, 1 + len(names)),
    )
    for name in names:
        end = facts["ends"][name]
        x, y, z = end["position"]
        failed = "failed: " if end["failed"] else ""
        print(
            f"{name:9}  {failed}{end['reason']} after {end['t']:.3f} s at x {x:.3f}, y {y:.3f}, z {z:.3f} m"
        )


def _remedy(facts: dict[str, Any], place: Any, command: _Command) -> list[str]:
    """What is to be done, in words."""
    from driftform_kit.ballast import MATERIALS, NEGLIGIBLE, ball_diameter

    density, mass, x = (facts[f"ballast_{name}"] for name in ("density", "mass", "x"))
    if abs(mass) < NEGLIGIBLE:
        moment = facts["residual_moment"]
        if abs(moment) < _NO_MOMENT:
            return ["no ballast: it weighs what was simulated, and balances there"]
        return [f"no ballast: it weighs what was simulated, its moment is off by {1e6 * moment:+.3g} g mm"]
    if mass < 0:
        foam = facts["buoyancy"]
        return [
            f"too heavy by {-1000 * mass:.3f} g: print the hull {100 * foam['hull_excess']:.1f} % lighter (less infill or flow),",
            f"or add {1e6 * foam['volume']:.3f} cm3 of foam at {place(foam['x'])};",
            "trimmed below is with foam that the water does not feel, else as simulated",
        ]
    lines = [f"ballast: {1000 * mass:.3f} g at {place(x)}"]
    if not facts["pieces"]:
        return [*lines, *_refuse_ballast(facts, density)]
    exact = abs(facts["residual_moment"]) < _NEAR * mass
    lines.append(
        "there is room for it:" if exact else "it cannot lie there; the nearest that there is room for:"
    )
    lines += [f"  {_describe_piece(piece, density, place)}" for piece in facts["pieces"]]
    for piece in facts["pieces"]:
        if piece["diameter"] is not None:
            ball = piece["mass"] - piece["putty"]
            balls = ", ".join(
                f"{name} {1000 * ball_diameter(ball, d):.1f} mm" for name, d in MATERIALS.items()
            )
            lines.append(f"balls of {1000 * ball:.3f} g: {balls}")
    lines += _describe_holding(facts, command)
    if not exact:
        lines.append(f"its moment is then off by {1e6 * facts['residual_moment']:+.3g} g mm")
    return lines


def _refuse_ballast(facts: dict[str, Any], density: float) -> list[str]:
    """Why no ballast can be put in, and what to do."""
    lines = _name_misfits(facts)
    if lines:
        return [
            *lines,
            f"no other seat can be printed: {facts['unheld']}",
            "export the kit again without ballast, print it lighter, and trim it without the option ballast",
        ]
    return [
        f"at {density:g} kg/m3 there is no room for it inside that it can be put to: a ball must pass the bore from the joint "
        "at the core, a ring of putty leave half of the bore free, and a filling be 1 mm thick; take something denser or "
        "lighter, or print it heavier",
    ]


def _describe_piece(piece: dict[str, Any], density: float, place: Any) -> str:
    from driftform_kit.ballast import MATERIALS, name_material

    at = f"{1000 * piece['mass']:.3f} g at {place(piece['x'])}"
    if piece["diameter"] is not None:
        name, size = name_material(density), f"{1000 * piece['diameter']:.1f} mm"
        ball = f"{at}: a {name} ball of {size}" if name in MATERIALS else f"{at}: a ball of {size}, {name}"
        return f"{ball}, in {1000 * piece['putty']:.3f} g of epoxy putty" if piece["putty"] else ball
    if piece["ring"] is not None:
        return f"{at}: a ring of epoxy putty on the wall, {1000 * piece['ring']:.1f} mm wide and thick, without a ball"
    return f"{at}: fills the bore from x {1000 * piece['start']:+.1f} to {1000 * piece['end']:+.1f} mm"


def _name_misfits(facts: dict[str, Any]) -> list[str]:
    """The seats of the kit that are for other balls."""
    return [
        f"the seat in the {ball['part']} at {1000 * (ball['x'] - facts['aft_end']):.2f} mm from the aft end is for a ball of "
        f"{1000 * ball['diameter']:.1f} mm, and does not hold this ballast"
        for ball in facts["misfits"]
    ]


def _describe_holding(facts: dict[str, Any], command: _Command) -> list[str]:
    """How the ballast gets in, and what holds it there."""
    from driftform_kit.ballast import PUTTY

    held, lines = facts["held"], _name_misfits(facts)
    if not held:
        unheld = facts["unheld"]
        pieces = facts["pieces"]
        setting = ";"
        if any(piece["diameter"] is not None for piece in pieces):
            setting = f", and set it in epoxy putty, which counts as ballast with {PUTTY:g} kg/m3;"
        elif any(piece["putty"] for piece in pieces):
            setting = f"; the putty is taken to have {PUTTY:g} kg/m3;"
        return [
            *lines,
            f"put it in through the joint at the core, before the core{setting}",
            "then weigh the print again",
            f"no seat for it can be printed: {unheld}"
            if unheld
            else "a kit can be printed with a seat for it: --kit",
        ]
    lines += [
        _describe_seat(ball, piece, facts["aft_end"])
        for ball, piece in zip(held, facts["pieces"], strict=True)
    ]
    if facts["misfits"] or facts["seat_mass"] >= 1e-5:
        lines += _describe_export(facts, command)
    return lines


def _describe_seat(ball: dict[str, Any], piece: dict[str, Any], aft: float) -> str:
    way = (
        f"put it in by the joint {1000 * (ball['mouth'] - aft):.1f} mm from the aft end, before that is joined"
        if ball["pause"] is None
        else f"put it in while that is printed, by a pause at {1000 * ball['pause']:.1f} mm"
    )
    return (
        f"{'a seat' if ball['held_by'] == 'seat' else 'the wall'} in the {ball['part']} holds the ball of "
        f"{1000 * piece['mass']:.3f} g: {way}, and fix it with a drop of glue"
    )


def _describe_export(facts: dict[str, Any], command: _Command) -> list[str]:
    """How to print the seats that hold the ballast."""
    balls = tuple((round(ball["x"], 5), round(ball["diameter"], 5)) for ball in facts["held"])
    changed = [*facts["misfits"], *facts["held"]]
    parts = " and the ".join(dict.fromkeys(ball["part"] for ball in changed if ball["held_by"] == "seat"))
    seat = f"{1000 * facts['seat_mass']:.3f} g of seat"
    if facts["misfits"]:
        seat = f"another seat, {1000 * facts['seat_mass']:+.3f} g"
    weighed = "without the ball"
    if inside := sum(
        piece["mass"]
        for piece, ball in zip(facts["pieces"], facts["held"], strict=True)
        if ball["pause"] is not None
    ):
        weighed = f"take off the {1000 * inside:.3f} g of ballast that is inside"
    export, trim = command.write(balls, facts["ballast_density"])
    return [
        f"print the {parts} again with the same flow, and with {seat}, which is counted above:",
        f"  {export}",
        f"then weigh it, {weighed}, and trim again:",
        f"  {trim}",
    ]
