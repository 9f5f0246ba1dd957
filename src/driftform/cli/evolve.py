"""``driftform evolve``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
    Workers,
)

if TYPE_CHECKING:
    from driftform.execution import Executor
    from driftform.runs.results import Best
    from driftform.runs.store import Store
    from driftform.study import Study


def evolve(
    study: Annotated[
        str, typer.Argument(metavar="STUDY", help="A study file, or the name of a built-in scenario.")
    ] = "pipe-inspection",
    target: Annotated[
        list[str] | None, typer.Option("--target", metavar="NAME", help="Keep only this target; repeatable.")
    ] = None,
    strategy: Annotated[
        str | None, typer.Option("--strategy", metavar="NAME", help="Search strategy to use.")
    ] = None,
    evaluations: Annotated[
        int | None,
        typer.Option(
            "--evaluations", metavar="N", min=1, help="Flights in all; by default 50 for each target."
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(
            "--seed", metavar="N", min=0, help="Seed of all randomness; drawn and recorded by default."
        ),
    ] = None,
    robust: Robust = None,
    workers: Workers = None,
    executor: ExecutorName = None,
    scheduler: Scheduler = None,
    simulator: Simulator = None,
    hydrodynamics: Hydrodynamics = None,
    out: OutDirectory = None,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Evolve agents for every target of a scenario.

    Writes a run directory: the study, every evaluation, and the best agent of each target with its mesh. Same
    seed, same result, whatever the workers and wherever they are. Interrupted or killed, it goes on with
    'driftform resume'.

    With --robust the best of the run are flown again, each time a little different from what was planned, and the
    best agent of a target is the one that does best then.
    """
    from driftform.cli.executors import open_executor
    from driftform.runs.directory import DATABASE, check_new, lock_run, write_inputs
    from driftform.runs.store import Store
    from driftform.study import load_study
    from driftform.study.sources import read_scenarios
    from driftform.util.files import make_directory

    disturbed = () if robust is None else (f"robustness.conditions={robust}",)
    checked = load_study(
        study,
        (*(settings or ()), *disturbed),
        targets=target or (),
        use={"strategy": strategy, "simulator": simulator, "hydrodynamics": hydrodynamics},
        run={"seed": seed, "evaluations": evaluations},
    )
    _check_targets(checked, study)
    if out is not None:
        check_new(out)
    with open_executor(checked, executor, scheduler, workers) as place:
        directory = make_directory(out) if out is not None else _next_directory(study)
        with lock_run(directory):
            # Another process may have been quicker.
            check_new(directory)
            path = Path(study)
            given = path.read_text(encoding="utf-8") if path.is_file() else read_scenarios()[study]
            write_inputs(directory, checked, given)
            with Store.create(directory / DATABASE, dict(checked.document)) as store:
                carry_out(directory, checked, store, place, json)


def carry_out(directory: Path, study: "Study", store: "Store", executor: "Executor", json: bool) -> None:
    """Run the loop to the end of the budget, write what it found, and report."""
    import time

    from driftform.cli.progress import Progress
    from driftform.execution import WorkersLostError
    from driftform.runs.finalists import fly_finalists
    from driftform.runs.results import write_best, write_reach
    from driftform.runs.search import run_search as run_loop
    from driftform.util.progress import count_progress

    started = time.perf_counter()
    try:
        with Progress(study, directory, store.count()) as progress:
            run_loop(study, store, executor, progress.record, progress.generation)
        with count_progress("disturbed flights") as on_flights:
            fly_finalists(study, store, executor, on_flights)
        results, overview = write_best(directory, study, store)
        reach = write_reach(directory, study, store)
    except KeyboardInterrupt:
        typer.echo(_stopped(directory, study, store), err=True)
        raise typer.Exit(130) from None
    except WorkersLostError as error:
        raise WorkersLostError(f"{error}; {_stopped(directory, study, store)}") from None
    seconds = time.perf_counter() - started

    from driftform.cli.output import print_json
    from driftform.errors import WorkFailedError

    if json:
        print_json(
            {
                "run": str(directory),
                "seed": study.seed,
                "evaluations": store.count(),
                "failed": store.count_failed(),
                "seconds": seconds,
                "targets": {
                    best.target: {
                        "fitness": best.fitness,
                        "error_percent": best.error_percent,
                        "distance": best.distance,
                        "robust": best.robust,
                        "agent": str(best.agent),
                        "files": [str(path) for path in best.files],
                    }
                    for best in results
                },
                "overview": str(overview),
                "reach": str(reach),
            }
        )
    else:
        _print_results(directory, study, store, results, (overview, reach), seconds)
    problems = [problem for best in results for problem in best.problems]
    if problems:
        raise WorkFailedError(*problems)


def _stopped(directory: Path, study: "Study", store: "Store") -> str:
    from driftform.runs.directory import resume_command

    return (
        f"stopped after {store.count()} of {study.evaluations} evaluations; "
        f"go on with: {resume_command(directory)}"
    )


def _print_results(
    directory: Path,
    study: "Study",
    store: "Store",
    results: "list[Best]",
    pictures: tuple[Path, Path],
    seconds: float,
) -> None:
    from driftform.cli.output import print_table

    has_spread = any(best.robust for best in results)
    spread = ("disturbed: mean", "worst") if has_spread else ()
    print_table(
        ("target", "x m", "y m", "z m", "fitness %", "error % of d_max", *spread, "closest mm", "agent"),
        (
            (
                best.target,
                *(f"{c:g}" for c in study.scenario.targets[best.target]),
                f"{best.fitness:.3f}",
                f"{best.error_percent:.3f}",
                *(f"{100 - best.robust[key]:.3f}" for key in ("mean", "worst") if best.robust),
                f"{1000 * best.distance:.1f}",
                str(best.agent),
            )
            for best in results
        ),
        right=(1, 2, 3, 4, 5, 6, 7, 8) if has_spread else (1, 2, 3, 4, 5, 6),
    )
    names = ", ".join(path.name for path in results[0].files) if results else ""
    print(
        f"{store.count()} evaluations ({store.count_failed()} failed) in {seconds:.1f} s, seed {study.seed}"
    )
    print(f"best agents: {directory}/best/<target>/ ({names})")
    print(f"pictures:    {', '.join(map(str, pictures))}")
    print(f"run:         {directory}/ (resolved.toml, environment.json, run.db)")


def _check_targets(study: "Study", source: str) -> None:
    from driftform.errors import InputError

    if not study.scenario.targets:
        raise InputError(f"{source}: has no [targets]; add at least one, such as leak = [4.0, 0.0, -0.9]")


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
