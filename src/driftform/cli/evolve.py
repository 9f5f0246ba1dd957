"""``driftform evolve``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli.options import (
    ExecutorName,
    Hydrodynamics,
    Json,
    OutDirectory,
    Robust,
    Scheduler,
    Settings,
    Simulator,
    StrategyName,
    StudyName,
    Workers,
)


def evolve(
    study: StudyName = "pipe-inspection",
    target: Annotated[list[str] | None, typer.Option(metavar="NAME", help="Keep only this target; repeatable.")] = None,
    strategy: StrategyName = None,
    evaluations: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Total budget of flights; by default 50 for each target.")
    ] = None,
    seed: Annotated[
        int | None, typer.Option(metavar="N", min=0, help="Seed of all randomness; drawn and recorded by default.")
    ] = None,
    robust: Robust = None,
    within: Annotated[
        float | None,
        typer.Option(
            metavar="M",
            help="How near a flight must pass a target to hit it, m; 5 % of the farthest distance by default.",
        ),
    ] = None,
    workers: Workers = None,
    executor: ExecutorName = None,
    scheduler: Scheduler = None,
    simulator: Simulator = None,
    hydrodynamics: Hydrodynamics = None,
    calibration: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="What filmed flights have shown of the model: a calibration.toml of 'driftform calibrate'.",
        ),
    ] = None,
    out: OutDirectory = None,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Evolve agents for every target of a scenario.

    Writes a run directory: the study, every evaluation, and the best agent of each target with its mesh. The same
    seed gives the same result, whatever the workers and wherever they are. An interrupted or killed run continues
    with 'driftform resume'.

    The best agents of the search are flown again under disturbed conditions. The one that is chosen for a target is
    then flown under fresh conditions, which show how many flights hit the target, and the miss that 9 of 10 stay within:
    as it comes from the printer, weighed and trimmed, and beside it a body that does nothing. --robust 0 leaves this out.
    """
    from driftform.study import load_study

    given = {"conditions": robust, "within": within}
    disturbed = (f"robustness.{key}={value}" for key, value in given.items() if value is not None)
    checked = load_study(
        study,
        (*(settings or ()), *disturbed),
        targets=target or (),
        use={"strategy": strategy, "simulator": simulator, "hydrodynamics": hydrodynamics},
        run={"seed": seed, "evaluations": evaluations},
        calibration=calibration,
    )
    # What runs a study takes a second to import. A wrong study is refused before, and its workers import meanwhile.
    from driftform.search.executors import open_executor

    with open_executor(checked, executor, scheduler, workers) as place:
        from driftform.cli.running import advance_run
        from driftform.runs.directory import check_new
        from driftform.runs.run import Run

        checked.check_search()
        if out is not None:
            check_new(out)
        warnings = checked.list_warnings()
        for warning in warnings:
            typer.echo(f"warning: {warning}", err=True)
        with Run.create(out or _next_directory(study), checked) as run:
            advance_run(run, place, json, warnings)


def _next_directory(study: str) -> Path:
    """Make the first free ``runs/<study>-<n>``."""
    from driftform.util.files import make_directory

    make_directory(Path("runs"))
    number = 1
    while True:
        path = Path("runs") / f"{Path(study).stem}-{number}"
        try:
            path.mkdir()
            return path
        except FileExistsError:
            number += 1
