"""``driftform trim``."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from driftform.cli.options import Agent, Hydrodynamics, Json, ScenarioOption, Settings, Simulator

if TYPE_CHECKING:
    from driftform.agents.opening import Opened
    from driftform.agents.sensitivity import Flown
    from driftform.printing.ballast import Piece, RequiredBallast
    from driftform.types import Agent as BuiltAgent

GRAMS_FOR_KG = 20
"""A printed mass of more than this many times the simulated one was given in another unit."""


def trim(
    agent: Agent,
    printed_mass: Annotated[
        float | None,
        typer.Option(
            "--printed-mass",
            metavar="KG",
            help="What the print weighs with its core, kg; with --kit by default what its parts should weigh.",
        ),
    ] = None,
    printed_cog: Annotated[
        float | None,
        typer.Option(
            "--printed-cog",
            metavar="M",
            help="Where it balances: x of its centre of gravity from the core's centre, fore positive, m; by default "
            "where the hull's material has it.",
        ),
    ] = None,
    kit: Annotated[
        bool,
        typer.Option(
            "--kit",
            help="It is printed as a kit, with the options of [exporter.stl]: its sleeves and seats weigh too.",
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
    """Tell the ballast that makes a print fly as simulated, and where it would go without."""
    from driftform.agents.opening import open_agent
    from driftform.agents.sensitivity import flown
    from driftform.cli.output import print_json
    from driftform.geometry.mass_elements import reweigh
    from driftform.printing.ballast import required_ballast

    opened = open_agent(
        agent,
        scenario,
        [*(settings or ()), *(["exporter.stl.kit=true"] if kit else [])],
        {"simulator": simulator, "hydrodynamics": hydrodynamics},
    )
    mass, cog, source = _weight(opened, printed_mass, printed_cog, kit)
    _check(opened, mass, cog, ballast_density)
    printed = reweigh(opened.agent, mass, cog)
    wanted = required_ballast(opened.agent.mass, printed.mass)
    trimmed, remedy = _trimmed(opened, mass, cog, wanted, ballast_density)
    flights = dict(
        zip(
            ("simulated", "untrimmed", *(("trimmed",) if trimmed else ())),
            flown(opened.pipeline, [opened.agent, printed, *([trimmed] if trimmed else [])], opened.name),
            strict=True,
        )
    )
    facts = {
        "agent": opened.name,
        "simulator": opened.pipeline.simulator.name,
        "simulated_mass": opened.agent.mass.mass,
        "simulated_cog": opened.agent.mass.cog[0],
        "printed_mass": mass,
        "printed_cog": printed.mass.cog[0],
        "cog_source": source,
        "aft_end": opened.agent.body.outer[:, 0].min(),
        "ballast_mass": wanted.mass,
        "ballast_x": wanted.x,
        **remedy,
        **{
            name: _by_target(opened, flights[name]) if name in flights else None
            for name in ("simulated", "untrimmed", "trimmed")
        },
        "ends": {
            name: {"t": f.flight.t[-1], "position": f.flight.position[-1], "reason": str(f.flight.end)}
            for name, f in flights.items()
        },
    }
    if json:
        print_json(facts)
    else:
        _print(facts, ballast_density)


def _weight(
    opened: "Opened", mass: float | None, cog: float | None, kit: bool
) -> tuple[float, float | None, str]:
    """Mass (kg) of the print, its centre of gravity (m; ``None``: the hull's material has it), and who says so."""
    from driftform.errors import InputError

    if mass is None and (not kit or cog is not None):
        raise InputError("--printed-mass is missing: weigh the print with its core in, kg")
    if mass is not None and (cog is not None or not kit or mass <= opened.agent.body.core.mass):
        return mass, cog, "hull" if cog is None else "measured"
    whole, x = _kit_balance(opened)
    if mass is None:
        return whole, x, "kit"
    # The core weighs what it weighs, at the origin: what differs is spread as the parts of the kit are.
    core = opened.agent.body.core.mass
    return mass, (mass - core) / mass * (whole * x / (whole - core)), "kit"


def _kit_balance(opened: "Opened") -> tuple[float, float]:
    """Mass (kg) and centre of gravity (m) of the kit with its core, as the exporter of its parts accounts for them."""
    from pathlib import Path
    from tempfile import TemporaryDirectory

    from driftform.errors import WorkFailedError

    with TemporaryDirectory() as folder:
        written = opened.study.make_exporter("stl").write(
            opened.export_job(), Path(folder) / f"{opened.name}.stl"
        )
    for file in written:
        for row in file.facts.get("kit", {}).get("balance", ()):
            if row["of"] == "printed":
                return float(row["mass_kg"]), float(row["cog_mm"]) / 1000
    raise WorkFailedError("exporter 'stl' does not tell how its kit balances; weigh it, and leave --kit out")


def _check(opened: "Opened", mass: float, x: float | None, density: float) -> None:
    import math

    from driftform.errors import InputError

    body, simulated = opened.agent.body, opened.agent.mass
    if not (math.isfinite(mass) and mass > body.core.mass):
        raise InputError(
            f"--printed-mass {mass:g}: should be more than the core's {body.core.mass:g} kg: weigh the print with its core in"
        )
    if mass > GRAMS_FOR_KG * simulated.mass:
        raise InputError(
            f"--printed-mass {mass:g}: is in kg, and {opened.name} was simulated with {simulated.mass:.4g} kg; "
            f"{mass:g} g are {mass / 1000:g}"
        )
    aft, fore = float(body.outer[:, 0].min()), float(body.outer[:, 0].max())
    if x is not None:
        if not aft < x < fore:
            raise InputError(
                f"--printed-cog {x:g}: lies outside the body, which reaches from x {aft:.4f} to {fore:.4f} m"
            )
        hull = mass * x / (mass - body.core.mass)
        if not aft < hull < fore:
            raise InputError(
                f"--printed-cog {x:g}: with its core at x 0, the hull alone would balance at x {hull:.4f} m, outside the "
                f"body ({aft:.4f} to {fore:.4f} m); weigh and balance it with its core in"
            )
    if not 1 < density < 1e5:
        raise InputError(
            f"--ballast-density {density:g}: should be a density in kg/m3, such as 11340 for lead"
        )


def _trimmed(
    opened: "Opened", mass: float, x: float | None, wanted: "RequiredBallast", density: float
) -> "tuple[BuiltAgent | None, dict[str, Any]]":
    """The agent with its ballast or buoyancy, ``None`` where there can be none, and what that is."""
    from driftform.errors import InputError
    from driftform.geometry.mass_elements import core_element, printed_hull_element
    from driftform.printing.ballast import NEGLIGIBLE, place_ballast, place_nearest

    body, fluid = opened.agent.body, opened.study.scenario.fluid
    lumps = [printed_hull_element(body, mass, x), core_element(body)]
    if density <= fluid.density and wanted.mass > 0:
        raise InputError(
            f"--ballast-density {density:g}: is no more than the water's {fluid.density:g} kg/m3"
        )
    found: tuple[Piece, ...] = ()
    buoyancy = None
    trimmed: BuiltAgent | None
    if abs(wanted.mass) < NEGLIGIBLE:
        trimmed = _loaded(opened, lumps)
    elif wanted.mass > 0:
        found = place_ballast(body, wanted, density) or place_nearest(body, wanted, density)
        trimmed = _loaded(opened, lumps + [piece.element for piece in found]) if found else None
    else:
        trimmed, buoyancy = _lifted(opened, lumps, wanted)
        buoyancy["hull_excess"] = -wanted.mass / lumps[0].mass
    residual = None
    if trimmed is not None and buoyancy is None:
        residual = trimmed.mass.mass * trimmed.mass.cog[0] - opened.agent.mass.mass * opened.agent.mass.cog[0]
    return trimmed, {
        "pieces": [
            {
                "mass": piece.element.mass,
                "x": piece.element.x,
                "start": piece.start,
                "end": piece.end,
                "diameter": piece.diameter,
            }
            for piece in found
        ],
        "residual_moment": residual,
        "buoyancy": buoyancy,
    }


def _loaded(opened: "Opened", lumps: "list[Any]") -> "BuiltAgent":
    from dataclasses import replace

    from driftform.geometry.mass_elements import combine

    return replace(opened.agent, mass=combine(lumps, opened.agent.mass))


def _lifted(
    opened: "Opened", lumps: "list[Any]", wanted: "RequiredBallast"
) -> "tuple[BuiltAgent, dict[str, Any]]":
    """With foam on the outside, that carries what it is too heavy by; its shape is not seen by the water."""
    from dataclasses import replace

    import numpy as np

    from driftform.geometry.mass_elements import MassElement
    from driftform.printing.ballast import FOAM

    agent, water = opened.agent, opened.study.scenario.fluid.density
    volume = -wanted.mass / (water - FOAM)
    aft, fore = agent.body.outer[0, 0], agent.body.outer[-1, 0]
    x = float(np.clip(wanted.x if wanted.x is not None else 0.0, aft, fore))
    loaded = _loaded(opened, [*lumps, MassElement(FOAM * volume, x)])
    displaced = agent.mass.volume + volume
    cob = (agent.mass.volume * agent.mass.cob[0] + volume * x) / displaced
    mass = replace(loaded.mass, volume=displaced, cob=np.array([cob, 0.0, 0.0]))
    return replace(agent, mass=mass), {"volume": volume, "density": FOAM, "x": x}


def _by_target(opened: "Opened", flown: "Flown") -> dict[str, float]:
    return dict(zip(opened.study.scenario.target_names, flown.fitness, strict=True))


def _print(facts: dict[str, Any], density: float) -> None:
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
    print("\nerror, % of d_max")
    names = [name for name in ("simulated", "untrimmed", "trimmed") if facts[name] is not None]
    print_table(
        ("target", *names),
        ((target, *(f"{100 - facts[name][target]:.3f}" for name in names)) for target in facts["simulated"]),
        right=range(1, 1 + len(names)),
    )
    for name in names:
        end = facts["ends"][name]
        x, y, z = end["position"]
        print(f"{name:9}  {end['reason']} after {end['t']:.3f} s at x {x:.3f}, y {y:.3f}, z {z:.3f} m")


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
    balls = ", ".join(f"{name} {1000 * ball_diameter(mass, d):.1f} mm" for name, d in MATERIALS.items())
    lines.append(f"as one ball across: {balls}")
    if not facts["pieces"]:
        return [
            *lines,
            f"there is no room for it inside at {density:g} kg/m3: take something denser, or print it heavier",
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
    if not exact:
        lines.append(f"its moment is then off by {1e6 * facts['residual_moment']:+.3g} g mm")
    return lines
