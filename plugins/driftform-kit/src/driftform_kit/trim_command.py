"""``driftform trim``."""

import shlex
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from driftform.cli import options

if TYPE_CHECKING:
    from driftform.interfaces import Fitness
    from driftform_kit.trim import Balls

Commands: TypeAlias = "Callable[[Balls, float], tuple[str, str]]"
"""Writes the commands that export the kit with balls of a density (kg/m3), and trim it then."""

_NO_MOMENT = 1e-9
"""Moment of ballast that counts as zero, kg m: a thousandth of a gram millimetre."""

_NEAR = 5e-5
"""m: ballast lies where it should if it is off by less than this; it cannot be laid more accurately."""


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
            help="x of the print's centre of gravity from the core's centre, fore positive, m; by default that of "
            "the hull's material.",
        ),
    ] = None,
    net_weight: Annotated[
        float | None,
        typer.Option(
            metavar="G",
            help="What a scale shows while the sealed agent hangs under water, g; positive if it sinks. In place of --printed-mass.",
        ),
    ] = None,
    water_temperature: Annotated[
        float | None,
        typer.Option(
            metavar="C", help="Temperature of that water, degrees C; by default that of the scenario, fluid.celsius."
        ),
    ] = None,
    kit: Annotated[
        bool,
        typer.Option(
            "--kit",
            help="Count the sleeves and seats of the kit; give --format, --bed and --option as for 'driftform export'.",
        ),
    ] = False,
    format: Annotated[str, typer.Option(metavar="NAME[,NAME...]", help="Formats that the kit is exported to.")] = "stl",
    bed: options.Bed = None,
    option: options.ExporterOptions = None,
    ballast_density: Annotated[
        float | None,
        typer.Option(
            metavar="KG/M3",
            help="Density of the ballast, kg/m3; by default that of the kit's options, or of steel, 7850.",
        ),
    ] = None,
    scenario: options.ScenarioOption = None,
    simulator: options.Simulator = None,
    hydrodynamics: options.Hydrodynamics = None,
    settings: options.Settings = None,
    json: options.Json = False,
) -> None:
    """Compute the ballast that makes a print fly as simulated, and show where it flies without it."""
    from driftform.cli import formats, output
    from driftform.errors import InputError
    from driftform_frusta.kit_options import STEEL
    from driftform_kit.ballast import name_material
    from driftform_kit.hang import describe_hanging, trim_in_water
    from driftform_kit.settings import list_arguments
    from driftform_kit.trim import trim_design

    names = formats.parse_formats(format, "exporter", "stl")
    for name, given in (("format", names != ["stl"]), ("bed", bed), ("option", option)):
        if given and not kit:
            raise InputError(f"--{name}: goes with --kit")
    use = {"simulator": simulator, "hydrodynamics": hydrodynamics}
    if net_weight is None and water_temperature is not None:
        raise InputError("--water-temperature: goes with --net-weight")
    if net_weight is not None:
        others = {
            "printed-mass": printed_mass,
            "printed-cog": printed_cog,
            "kit": kit or None,
            "ballast-density": ballast_density,
        }
        if given := [name for name, value in others.items() if value is not None]:
            raise InputError(
                f"--{given[0]}: does not go with --net-weight, which weighs the sealed agent: leave it out"
            )
    design = formats.open_exported(agent, names, kit, bed, option or (), settings or (), scenario, use)
    if net_weight is not None:
        facts = trim_in_water(design, net_weight / 1000, water_temperature)
    else:
        facts = trim_design(
            design, printed_mass, printed_cog, kit=kit, format=names[0], ballast_density=ballast_density
        )
    if json:
        output.print_json(facts)
        return
    if net_weight is not None:
        print(*describe_hanging(facts, design.agent.body), sep="\n")
        _print_flights(facts, design.pipeline.fitness)
        return
    exporter = design.study.make_exporter(names[0])
    kept = [setting for setting in settings or () if not setting.lstrip().startswith("exporter.")]
    again = {"scenario": scenario, **use}
    opened = shlex.join([agent, *(word for setting in kept for word in ("--set", setting))])
    flight = shlex.join(word for key, value in again.items() if value for word in (f"--{key}", value))

    def write(balls: "Balls", density: float) -> tuple[str, str]:
        changed: dict[str, Any] = {"ballast": balls}
        if name_material(density) != name_material(STEEL):
            changed["ballast_density"] = density
        arguments = f"{opened} {list_arguments(names, exporter.options.model_copy(update=changed))}"
        return (f"driftform export {arguments}", f"driftform trim {arguments} --printed-mass KG {flight}".rstrip())

    _print(facts, design.pipeline.fitness, write)


def _print(facts: dict[str, Any], fitness: "Fitness[Any]", commands: Commands) -> None:
    from driftform.cli import output

    aft = facts["aft_end"]
    sources = {"measured": "", "hull": "where the hull's material has it", "kit": "where the parts of the kit have it"}
    source = sources[facts["cog_source"]]
    masses = []
    for case, remark in (("simulated", ""), ("printed", f"; not measured: {source}" if source else "")):
        mass, x = (facts[f"{case}_{what}"] for what in ("mass", "cog"))
        place = f"x {1000 * x:+.2f} mm, {1000 * (x - aft):.2f} mm from the aft end{remark}"
        masses.append((case, f"{1000 * mass:.3f} g", place))
    output.print_table(("", "mass", "centre of gravity"), masses, right=(1,))
    print()
    for line in describe_remedy(facts, commands):
        print(line)
    _print_flights(facts, fitness)


def _print_flights(facts: dict[str, Any], fitness: "Fitness[Any]") -> None:
    from driftform.cli import output

    print(f"\n{fitness.heading}")
    names = [name for name in ("simulated", "untrimmed", "trimmed") if name in facts["ends"]]
    # A failed flight costs its column, not the others.
    columns = {name: facts[name] or {} for name in names}
    targets = list(dict.fromkeys(target for column in columns.values() for target in column))
    rows = [
        (target, *(f"{fitness.measure(c[target]):.3f}" if c else "-" for c in columns.values())) for target in targets
    ]
    output.print_table(("target", *names), rows, right=range(1, 1 + len(names)))
    for name in names:
        end = facts["ends"][name]
        x, y, z = end["position"]
        failed = "failed: " if end["failed"] else ""
        print(f"{name:9}  {failed}{end['reason']} after {end['t']:.3f} s at x {x:.3f}, y {y:.3f}, z {z:.3f} m")


def describe_remedy(facts: dict[str, Any], commands: Commands) -> list[str]:
    """Return what is to be done by the document of ``driftform trim``, one line each."""
    from driftform_kit.ballast import MATERIALS, NEGLIGIBLE, PUTTY, ball_diameter, name_material
    from driftform_kit.templates import fill_template

    held, density, off = facts["held"], facts["ballast_density"], facts["residual_moment"]
    export, trim = commands(tuple((round(b["x"], 5), round(b["diameter"], 5)) for b in held), density)
    paused = (piece["mass"] for piece, b in zip(facts["pieces"], held, strict=False) if b["pause"] is not None)
    return fill_template(
        "trim.txt",
        **facts,
        negligible=NEGLIGIBLE,
        no_moment=_NO_MOMENT,
        exact=off is not None and abs(off) < _NEAR * facts["ballast_mass"],
        material=name_material(density),
        materials=MATERIALS,
        putty=PUTTY,
        ball_diameter=ball_diameter,
        seats=dict.fromkeys(b["part"] for b in (*facts["misfits"], *held) if b["held_by"] == "seat"),
        inside=sum(paused),
        export=export,
        trim=trim,
    )
