"""``driftform drop``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from driftform.cli import options

if TYPE_CHECKING:
    from driftform_calibration.protocol import DropPlan


def drop(
    agent: options.Agent,
    tank: Annotated[
        tuple[float, float, float],
        typer.Option(
            metavar="LENGTH WIDTH DEPTH", help="Inside of the tank: along the picture, across it, of water; m."
        ),
    ] = (1.0, 0.5, 0.5),
    drops: Annotated[int, typer.Option(metavar="N", min=1, max=20, help="Number of drops to film.")] = 3,
    fps: Annotated[float, typer.Option(metavar="N", min=1, max=10_000, help="Frames per second of the film.")] = 60.0,
    noise: Annotated[
        float, typer.Option(metavar="M", min=1e-6, max=1, help="Standard deviation of a tracked point, m.")
    ] = 0.002,
    scenario: Annotated[
        str, typer.Option(metavar="NAME|FILE", help="Scenario with the water and the contact of the floor.")
    ] = "tank",
    hydrodynamics: options.Hydrodynamics = None,
    settings: options.Settings = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Directory for the files; by default drops/AGENT.")
    ] = None,
    json: options.Json = False,
) -> None:
    """Plan the drops in a tank whose films show most about the model: attitude, depth and ballast of each release.

    Writes a page to take to the tank (what to weigh, where to put the camera, a ruler to print) and a study file for each
    drop. Save the track of a film in the folder of its drop's file, for 'driftform calibrate'.
    """
    from driftform import open_agent
    from driftform.cli import output
    from driftform.util import files, progress
    from driftform_calibration.experiment import drop_design

    design = open_agent(agent, *(settings or ()), scenario=scenario, use={"hydrodynamics": hydrodynamics})
    directory = files.check_directory(out or Path("drops") / design.name)
    with progress.count_progress("releases") as show:
        plan = drop_design(design, tank, drops=drops, fps=fps, noise=noise, progress=show)
    paths = plan.write(directory)
    if json:
        output.print_json(plan.document(paths))
    else:
        _print(plan, paths)


def _print(plan: "DropPlan", paths: list[Path]) -> None:
    from driftform.cli import output

    document = plan.document()
    output.print_table(*plan.tabulate(), right=(0, 1, 3, 4, 5, 7))
    print()
    output.print_table(*plan.tabulate_expected(), right=(1,))
    output.print_text(
        f"weigh the print with core and ballast: {1000 * document['mass']:.2f} g as simulated; calibrate takes it as --printed-mass"
    )
    for path in paths:
        print(f"wrote {path}")
    tracks = " ".join(f"{path.with_suffix('.csv')}" for path in paths[1:])
    print(f"next: driftform calibrate AGENT {tracks}")
