"""``driftform pick``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from driftform.cli.options import Json

if TYPE_CHECKING:
    from driftform.scenario import Scenario, Vector

NUMBERS = {"ignore_unknown_options": True}
"""A coordinate such as -0.9 begins like an option, and is none."""


def pick(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    x: Annotated[
        float, typer.Argument(metavar="X", help="World coordinates of the point, m.", show_default=False)
    ],
    y: Annotated[float, typer.Argument(metavar="Y", help="Its second coordinate.", show_default=False)],
    z: Annotated[float, typer.Argument(metavar="Z", help="Its third coordinate.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Directory for the agent; by default RUN/picks/X_Y_Z."),
    ] = None,
    json: Json = False,
) -> None:
    """Find the agent of a run whose flight passes closest to a point, also to one that was no target.

    Every stored flight is looked at; the run may still be going on.
    """
    from driftform.cli.output import print_json
    from driftform.errors import InputError
    from driftform.runs.agent_file import StoredAgent, write_agent
    from driftform.runs.directory import check_run, resume_command
    from driftform.runs.store import Store
    from driftform.study import Document, load_study
    from driftform.trajectory.coverage import find_closest_pass
    from driftform.util.files import make_directory
    from driftform.util.progress import track_progress

    point = (x, y, z)
    database = check_run(run)
    with Store.open(database, read_only=True, check=False) as store:
        study = load_study(Document(str(database), store.read_study()))
        _check_point(point, study.scenario)
        found = find_closest_pass(
            track_progress(store.read_trajectories(), store.count_sound(), "flights"), point
        )
        if found is None:
            raise InputError(
                f"{run} has no evaluation yet that did not fail; wait, or go on with it by: {resume_command(run)}"
            )
        genome = store.read_record(found.evaluation, study.scenario.target_names).evaluation.genome
    place = "_".join(f"{value:.9g}" for value in point)
    folder = make_directory(out or run / "picks" / place)
    path = folder / "agent.json"
    result = {
        "point": list(point),
        "distance": found.distance,
        "t": found.t,
        "evaluation": found.evaluation,
    }
    name = f"{run.resolve().name}-{place}"
    write_agent(path, StoredAgent(name, genome, study.environment(found.evaluation), result))
    if json:
        print_json({"agent": str(path), **result})
        return
    print(
        f"evaluation {found.evaluation} passes closest to ({x:g}, {y:g}, {z:g}) m: "
        f"{1000 * found.distance:.1f} mm, after {found.t:.2f} s"
    )
    print(f"agent: {path}")


def _check_point(point: "Vector", scenario: "Scenario") -> None:
    """Refuse a point that no flight can pass."""
    from math import isfinite

    from driftform.errors import InputError

    told = "X Y Z = " + " ".join(f"{value:g}" for value in point)
    if not all(map(isfinite, point)):
        raise InputError(f"{told}: should be three finite numbers, in m")
    if scenario.pipe.segments and not scenario.pipe.contains(point):
        pipes = ", then ".join(
            f"from {list(s.start)} to {list(s.end)} with radius {s.radius:g} m"
            for s in scenario.pipe.segments
        )
        raise InputError(f"{told} lies outside the pipe, which leads {pipes}")
