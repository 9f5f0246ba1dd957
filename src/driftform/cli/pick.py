"""``driftform pick``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli.options import Json, RunArgument

NUMBERS = {"ignore_unknown_options": True}
"""A coordinate such as -0.9 begins like an option."""


def pick(
    run: RunArgument,
    x: Annotated[float, typer.Argument(metavar="X", help="World coordinates of the point, m.")],
    y: Annotated[float, typer.Argument(metavar="Y", help="Its second coordinate.")],
    z: Annotated[float, typer.Argument(metavar="Z", help="Its third coordinate.")],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Directory for the agent; by default RUN/picks/X_Y_Z.")
    ] = None,
    json: Json = False,
) -> None:
    """Find the agent of a run whose flight passes closest to any point, also to one that was not a target.

    Searches every stored flight; the run need not be finished.
    """
    from driftform.cli.output import print_json
    from driftform.runs.run import Run
    from driftform.search.picking import write_pick

    stored, path = write_pick(Run.open(run, check=False), (x, y, z), out)
    if json:
        print_json({"agent": str(path), **stored.result})
        return
    found = stored.result
    print(
        f"evaluation {found['evaluation']} passes closest to ({x:g}, {y:g}, {z:g}) m: "
        f"{1000 * found['distance']:.1f} mm, after {found['t']:.2f} s"
    )
    print(f"agent: {path}")
