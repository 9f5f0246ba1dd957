"""``driftform evolve``."""

from pathlib import Path
from types import SimpleNamespace

import typer

from driftform.cli.options import FILE, declare


@declare(
    FILE,
    *(
        "study",
        "target",
        "strategy",
        "evaluations",
        "seed",
        "robust",
        "within",
        "workers",
        "scheduler",
        "simulator",
        "hydrodynamics",
        "grammar",
        "fitness",
        "calibration",
        "out",
        "settings",
        "json",
    ),
)
def evolve(given: SimpleNamespace) -> None:
    """Evolve agents for every target of a scenario.

    Writes a run directory: the study, every evaluation, and the best agent of each target with its mesh. The same
    seed gives the same result with any number of workers, wherever they are. An interrupted or killed run continues
    with 'driftform resume'.

    The best agents of the search are flown again under disturbed conditions. The agent that is chosen for a target is
    then flown under new disturbed conditions: the result is the share of flights that hit the target, and the miss that
    9 of 10 flights stay within, as printed, weighed and trimmed, and for the baseline. --robust 0 omits this.
    """
    from driftform.study import load_study

    seams = ("strategy", "simulator", "hydrodynamics", "grammar", "fitness")
    use = {seam: getattr(given, seam) for seam in seams}
    checked = load_study(
        given.study,
        given.settings or (),
        targets=given.target or (),
        use=use,
        run={"seed": given.seed, "evaluations": given.evaluations, "robust": given.robust, "within": given.within},
        calibration=given.calibration,
    )
    # The modules that run a study take a second to import. A wrong study is refused before, and workers import meanwhile.
    from driftform.search.executors import open_executor

    with open_executor(checked, given.scheduler, given.workers) as place:
        from driftform.cli.running import advance_run
        from driftform.runs.directory import check_new
        from driftform.runs.run import StoredRun
        from driftform.util.files import make_directory, make_numbered_directory

        checked.check_search()
        if given.out is not None:
            check_new(given.out)
        warnings = checked.list_warnings()
        for warning in warnings:
            typer.echo(f"warning: {warning}", err=True)
        directory = given.out or make_numbered_directory(make_directory(Path("runs")), Path(given.study).stem)
        with StoredRun.create(directory, checked) as run:
            advance_run(run, place, given.json, warnings)
