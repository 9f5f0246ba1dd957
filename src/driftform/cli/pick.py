"""``driftform pick``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli.options import Json, RunArgument, make_option

NUMBERS = {"ignore_unknown_options": True}
"""A coordinate such as -0.9 begins like an option."""


def pick(
    run: RunArgument,
    x: Annotated[float | None, typer.Argument(metavar="X", help="x of the point in world coordinates, m.")] = None,
    y: Annotated[float | None, typer.Argument(metavar="Y", help="y of the point, m.")] = None,
    z: Annotated[float | None, typer.Argument(metavar="Z", help="z of the point, m.")] = None,
    place: Annotated[
        str | None,
        make_option(
            "TOML",
            "Place in the pipe instead of X Y Z, such as 'part = \"straight 2\", at = 1.2, clock = 12, off_wall = 0.03'.",
        ),
    ] = None,
    out: Annotated[Path | None, make_option("DIR", "Directory for the agent; by default RUN/picks/X_Y_Z.")] = None,
    json: Json = False,
) -> None:
    """Find the agent of a run whose flight passes closest to a point, which need not be a target.

    Searches every stored flight; the run need not be finished.
    """
    from driftform.cli.output import print_json
    from driftform.errors import InputError
    from driftform.runs.run import StoredRun
    from driftform.search.picking import find_place, write_pick

    opened = StoredRun.open(run, check=False)
    if place is not None and x is None:
        x, y, z = find_place(place, opened.study.scenario.pipe)
    elif place is not None or x is None or y is None or z is None:
        raise InputError("a point is named by X Y Z, its coordinates in m, or by --place")
    stored, path = write_pick(opened, (x, y, z), out)
    if json:
        print_json({"agent": str(path), **stored.result})
        return
    found = stored.result
    print(
        f"evaluation {found['evaluation']} passes closest to ({x:g}, {y:g}, {z:g}) m: "
        f"{1000 * found['distance']:.1f} mm, after {found['t']:.2f} s"
    )
    print(f"agent: {path}")
