"""``driftform evolve``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli.options import (
    FitnessName,
    GrammarName,
    Hydrodynamics,
    Json,
    Robust,
    Scheduler,
    Settings,
    Simulator,
    StrategyName,
    StudyName,
    Workers,
    make_option,
)


def evolve(
    study: StudyName = "pipe-inspection",
    target: Annotated[list[str] | None, make_option("NAME", "Search for this target only; repeatable.")] = None,
    strategy: StrategyName = None,
    evaluations: Annotated[
        int | None, make_option("N", "Total number of flights; by default 50 per target.", min=1)
    ] = None,
    seed: Annotated[
        int | None, make_option("N", "Seed of the random numbers; by default random, and recorded.", min=0)
    ] = None,
    robust: Robust = None,
    within: Annotated[
        float | None,
        make_option(
            "M", "Largest miss of a flight that counts as a hit, m; by default 5 % of the largest possible miss."
        ),
    ] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    simulator: Simulator = None,
    hydrodynamics: Hydrodynamics = None,
    grammar: GrammarName = None,
    fitness: FitnessName = None,
    calibration: Annotated[
        str | None,
        make_option(
            "FILE", "Corrections of the model by filmed flights: the calibration.toml of 'driftform calibrate'."
        ),
    ] = None,
    out: Annotated[Path | None, make_option("DIR", "Directory of the run; by default runs/STUDY-N.")] = None,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Evolve agents for every target of a scenario.

    Writes a run directory: the study, every evaluation, and the best agent of each target with its mesh. The same
    seed gives the same result with any number of workers, wherever they are. An interrupted or killed run continues
    with 'driftform resume'.

    The best agents of the search are flown again under disturbed conditions. The agent that is chosen for a target is
    then flown under new disturbed conditions: the result is the share of flights that hit the target, and the miss that
    9 of 10 flights stay within, as printed, weighed and trimmed, and for the baseline. --robust 0 omits this.
    """
    from driftform.study import load_study

    use = {
        "strategy": strategy,
        "simulator": simulator,
        "hydrodynamics": hydrodynamics,
        "grammar": grammar,
        "fitness": fitness,
    }
    checked = load_study(
        study,
        settings or (),
        targets=target or (),
        use=use,
        run={"seed": seed, "evaluations": evaluations, "robust": robust, "within": within},
        calibration=calibration,
    )
    # The modules that run a study take a second to import. A wrong study is refused before, and workers import meanwhile.
    from driftform.search.executors import open_executor

    with open_executor(checked, scheduler, workers) as place:
        from driftform.cli.running import advance_run
        from driftform.runs.directory import check_new
        from driftform.runs.run import StoredRun
        from driftform.util.files import make_directory, make_numbered_directory

        checked.check_search()
        if out is not None:
            check_new(out)
        warnings = checked.list_warnings()
        for warning in warnings:
            typer.echo(f"warning: {warning}", err=True)
        directory = out or make_numbered_directory(make_directory(Path("runs")), Path(study).stem)
        with StoredRun.create(directory, checked) as run:
            advance_run(run, place, json, warnings)
