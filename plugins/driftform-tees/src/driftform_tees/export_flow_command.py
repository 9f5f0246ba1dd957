"""``driftform export-flow``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli import options


def export_flow(
    study: Annotated[str, typer.Argument(metavar="STUDY", help="Study file, or the name of a built-in scenario.")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="File to write, .csv; an older one is replaced.")] = Path(
        "currents.csv"
    ),
    spacing: Annotated[
        float | None,
        typer.Option(
            metavar="M",
            help="Distance of the nodes, m; by default a twentieth of the narrowest bore, or more in a long pipe.",
        ),
    ] = None,
    settings: options.Settings = None,
    json: options.Json = False,
) -> None:
    """Write the mean current in the pipe of a study on a regular grid, for Gazebo and for flow.kind = "grid".

    The file is a table with the columns timestamp, x, y, z, u, v and w. Gusts are left out.
    """
    from driftform import load_study
    from driftform.cli import output
    from driftform.errors import InputError
    from driftform.util import files
    from driftform_tees.currents import sample_current, warn_of_flow, write_current

    if out.suffix.lower() != ".csv":
        raise InputError(f"--out {out}: the file is CSV; choose a name that ends in .csv")
    if out.is_dir():
        raise InputError(f"--out {out}: is a directory; choose the name of a file")
    files.check_directory(out.parent)
    scenario = load_study(study, settings or ()).scenario
    grid = sample_current(scenario, spacing)
    nodes = write_current(out, grid)
    warnings, speed = warn_of_flow(scenario), scenario.flow.speed
    if json:
        output.print_json(
            {
                "file": str(out),
                "nodes": nodes,
                "shape": list(grid.shape),
                "origin": grid.origin.tolist(),
                "spacing": float(grid.spacing[0]),
                "speed": speed,
                "warnings": warnings,
            }
        )
        return
    shape = " x ".join(map(str, grid.shape))
    print(f"{out}: {nodes} nodes, {1000 * grid.spacing[0]:g} mm apart, of a grid of {shape}")
    print(f'read it with flow.kind = "grid", flow.file = "{out}", flow.reference = {speed:g}')
    for warning in warnings:
        output.print_text(f"warning: {warning}")
