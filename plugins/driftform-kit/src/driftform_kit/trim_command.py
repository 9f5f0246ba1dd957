"""``driftform trim``."""

import shlex
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace as Given
from typing import TYPE_CHECKING, Any, TypeAlias

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


@options.declare(
    Path(__file__).with_name("trim.toml"),
    *("agent", "printed_mass", "printed_cog", "net_weight", "water_temperature", "kit", "format", "bed", "option"),
    *("ballast_density", "scenario", "simulator", "hydrodynamics", "settings", "json"),
)
def trim(given: Given) -> None:
    """Compute the ballast that makes a print fly as simulated, and show where it flies without it."""
    from driftform.cli import formats, output
    from driftform.errors import InputError
    from driftform_frusta.kit_options import STEEL
    from driftform_kit.ballast import name_material
    from driftform_kit.hang import describe_hanging, trim_in_water
    from driftform_kit.settings import list_arguments
    from driftform_kit.trim import trim_design

    names = formats.parse_formats(given.format, "exporter", "stl")
    net_weight, settings = given.net_weight, given.settings or ()
    for name, value in (("format", names != ["stl"]), ("bed", given.bed), ("option", given.option)):
        if value and not given.kit:
            raise InputError(f"--{name}: goes with --kit")
    use = {"simulator": given.simulator, "hydrodynamics": given.hydrodynamics}
    if net_weight is None and given.water_temperature is not None:
        raise InputError("--water-temperature: goes with --net-weight")
    if net_weight is not None:
        for name in ("printed-mass", "printed-cog", "kit", "ballast-density"):
            value = getattr(given, name.replace("-", "_"))
            if value is not None and value is not False:
                raise InputError(
                    f"--{name}: does not go with --net-weight, which weighs the sealed agent: leave it out"
                )
    design = formats.open_exported(
        given.agent, names, given.kit, given.bed, given.option or (), settings, given.scenario, use
    )
    if net_weight is not None:
        facts = trim_in_water(design, net_weight / 1000, given.water_temperature)
    else:
        how = {"kit": given.kit, "format": names[0], "ballast_density": given.ballast_density}
        facts = trim_design(design, given.printed_mass, given.printed_cog, **how)
    if given.json:
        output.print_json(facts)
        return
    if net_weight is not None:
        print(*describe_hanging(facts, design.agent.body), sep="\n")
        _print_flights(facts, design.pipeline.fitness)
        return
    exporter = design.study.make_exporter(names[0])
    kept = [setting for setting in settings if not setting.lstrip().startswith("exporter.")]
    again = {"scenario": given.scenario, **use}
    opened = shlex.join([given.agent, *(word for setting in kept for word in ("--set", setting))])
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
