"""``driftform body``."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace as Given

import typer

from driftform.cli import options


@options.declare(
    Path(__file__).with_name("body.toml"),
    *("profile", "mass", "cog", "inertia", "coefficients", "unit", "flip", "scenario", "settings", "out", "json"),
)
def body(given: Given) -> None:
    """Make an agent of your own body from its profile, mass and centre of gravity; all commands take it."""
    from driftform import Design, StoredAgent, load_study
    from driftform.cli import output
    from driftform.errors import InputError
    from driftform.types import Genome
    from driftform.util import files
    from driftform_frusta.own.coefficients import KINDS, measure_model
    from driftform_frusta.own.profile import MAX_DEVIATION, MAX_FINS, read_profile

    profile, coefficients, mass, cog = given.profile, given.coefficients, given.mass, given.cog
    limit = MAX_DEVIATION if coefficients is None else MAX_FINS
    file, shape = given.out or Path(f"{profile.stem}.json"), read_profile(profile, given.unit, given.flip, limit)
    if cog > shape.length:
        raise InputError(
            f"--cog {cog:g}: lies past the end of {profile}, which is {shape.length:.4g} m long: give m from the nose, and the unit of the file by --unit"
        )
    made = {"use": "profile", "profile": shape.points.round(9).tolist(), "mass": mass, "cog": cog}
    made |= {"inertia": list(given.inertia)} if given.inertia else {}
    water = load_study(given.scenario, given.settings or ()).environment()
    stored = StoredAgent(file.stem, Genome("fixed", ()), {**water, "grammar": {"use": "fixed"}, "builder": made}, {})
    design = Design.build(stored, str(file)).under()
    measured: list[str] = []
    if coefficients is not None:
        model, measured = measure_model(coefficients, design)
        stored = replace(stored, environment={**stored.environment, "hydrodynamics": model})
        design = Design.build(stored, str(file)).under()
    if shape.deviation > MAX_DEVIATION:
        lacking = [f"{kind.replace('_', ' ')}, which {coefficients} lacks" for kind in KINDS if kind not in measured]
        typer.echo(
            f"warning: {profile}: what deviates by {100 * shape.deviation:.1f} % of the diameter from a solid of revolution, such as "
            f"fins, is left out of {'; '.join(['contact', 'lift', *lacking])}",
            err=True,
        )
    files.make_directory(file.parent, "--out")
    design.stored.write(file)
    added = design.coefficients.added_mass
    displaced = design.scenario.fluid.density * design.mass.volume
    cob = float(design.agent.body.outer[-1, 0] - design.mass.cob[0])
    facts = {
        "agent": str(file),
        "length": shape.length,
        "max_diameter": design.max_diameter,
        "deviation": shape.deviation,
        "axis": shape.axis,
        "mass": design.mass.mass,
        "displaced": displaced,
        "net_buoyancy": design.net_buoyancy,
        "cog": cog,
        "cob": cob,
        "added_mass": [float(added[i, i]) for i in (0, 1, 4)],
        "hydrodynamics": design.pipeline.hydrodynamics.name,
        "measured": measured,
    }
    if given.json:
        output.print_json(facts)
        return
    print(f"{profile}: {1000 * shape.length:.1f} mm long, {1000 * design.max_diameter:.1f} mm in diameter")
    if shape.axis is not None:
        print(f"axis:      ({', '.join(f'{c:.4f}' for c in shape.axis)}) in the file, from tail to nose")
        print(f"deviation: {100 * shape.deviation:.2f} % of the diameter from a solid of revolution")
    print(f"mass:      {mass:g} kg, displaces {displaced:.5g} kg: {design.net_buoyancy:+.4g} N")
    print(f"centres:   of gravity {1000 * cog:.1f} mm from the nose, of buoyancy {1000 * cob:.1f} mm")
    print(
        f"added:     {added[0, 0]:.4g} kg along the axis, {added[1, 1]:.4g} kg across it, by {facts['hydrodynamics']}"
    )
    if measured:
        print(f"measured:  {', '.join(measured).replace('_', ' ')}")
    print(f"agent:     {file}; driftform inspect {file}")
