"""``driftform trim``."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from driftform.cli.options import Agent, Hydrodynamics, Json, ScenarioOption, Settings, Simulator

if TYPE_CHECKING:
    from driftform.interfaces import Fitness


def trim(
    agent: Agent,
    printed_mass: Annotated[
        float | None,
        typer.Option(
            "--printed-mass",
            metavar="KG",
            help="Mass of the print with its core, kg; with --kit by default that of its parts.",
        ),
    ] = None,
    printed_cog: Annotated[
        float | None,
        typer.Option(
            "--printed-cog",
            metavar="M",
            help="x of its centre of gravity from the core's centre, fore positive, m; by default that of the "
            "hull's material.",
        ),
    ] = None,
    kit: Annotated[
        bool,
        typer.Option(
            "--kit",
            help="Count the sleeves and seats of the kit, with the options of [exporter.stl].",
        ),
    ] = False,
    ballast_density: Annotated[
        float,
        typer.Option(
            "--ballast-density", metavar="KG/M3", help="Density of the ballast, kg/m3; lead's is 11340."
        ),
    ] = 11_340.0,
    scenario: ScenarioOption = None,
    simulator: Simulator = None,
    hydrodynamics: Hydrodynamics = None,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Compute the ballast that makes a print fly as simulated, and show its path without it."""
    from driftform.agents.opening import open_agent
    from driftform.cli.output import print_json

    design = open_agent(
        agent, scenario, settings or (), {"simulator": simulator, "hydrodynamics": hydrodynamics}
    )
    facts = design.trim(printed_mass, printed_cog, kit=kit, ballast_density=ballast_density)
    if json:
        print_json(facts)
    else:
        _print(facts, ballast_density, design.pipeline.fitness)


def _print(facts: dict[str, Any], density: float, fitness: "Fitness[Any]") -> None:
    from driftform.cli.output import print_table

    aft = facts["aft_end"]

    def place(x: float) -> str:
        return f"x {1000 * x:+.2f} mm, {1000 * (x - aft):.2f} mm from the aft end"

    source = {
        "measured": "",
        "hull": "; not measured: where the hull's material has it",
        "kit": "; not measured: where the parts of the kit have it",
    }[facts["cog_source"]]
    print_table(
        ("", "mass", "centre of gravity"),
        [
            ("simulated", f"{1000 * facts['simulated_mass']:.3f} g", place(facts["simulated_cog"])),
            ("printed", f"{1000 * facts['printed_mass']:.3f} g", place(facts["printed_cog"]) + source),
        ],
        right=(1,),
    )
    print()
    for line in _remedy(facts, density, place):
        print(line)
    print(f"\n{fitness.heading}")
    names = [name for name in ("simulated", "untrimmed", "trimmed") if name in facts["ends"]]
    # A failed flight costs its column, not the others.
    columns = {name: facts[name] or {} for name in names}
    targets = list(dict.fromkeys(target for column in columns.values() for target in column))
    print_table(
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


def _remedy(facts: dict[str, Any], density: float, place: Any) -> list[str]:
    """What is to be done, in words."""
    from driftform.printing.ballast import MATERIALS, NEGLIGIBLE, ball_diameter

    mass, x = facts["ballast_mass"], facts["ballast_x"]
    if abs(mass) < NEGLIGIBLE:
        moment = facts["residual_moment"]
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
        return [
            *lines,
            f"at {density:g} kg/m3 there is no room for it inside that it can be put to: a ball must pass the bore from the "
            "joint at the core, and a filling be 1 mm thick; take something denser or lighter, or print it heavier",
        ]
    exact = abs(facts["residual_moment"]) < 1e-3 * abs(mass) * 1e-3
    lines.append(
        "there is room for it:" if exact else "it cannot lie there; the nearest that there is room for:"
    )
    for piece in facts["pieces"]:
        at = f"{1000 * piece['mass']:.3f} g at {place(piece['x'])}"
        if piece["diameter"] is not None:
            lines.append(f"  {at}: a ball of {1000 * piece['diameter']:.1f} mm")
        else:
            start, end = 1000 * piece["start"], 1000 * piece["end"]
            lines.append(f"  {at}: fills the bore from x {start:+.1f} to {end:+.1f} mm")
    if len(facts["pieces"]) == 1 and facts["pieces"][0]["diameter"] is not None:
        balls = ", ".join(f"{name} {1000 * ball_diameter(mass, d):.1f} mm" for name, d in MATERIALS.items())
        lines.append(f"balls of that mass: {balls}")
    lines += [
        "put it in through the joint at the core, before the core; a kit has no seat for it:",
        "set it in epoxy putty, which counts as ballast, and weigh the print again",
    ]
    if not exact:
        lines.append(f"its moment is then off by {1e6 * facts['residual_moment']:+.3g} g mm")
    return lines
