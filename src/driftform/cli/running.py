"""What ``evolve`` and ``resume`` share: advance a run, and print what it found."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from driftform.runs.run import StoredRun
    from driftform.search.pool import Executor
    from driftform.search.results import Best


def advance_run(run: "StoredRun", executor: "Executor", json: bool, warnings: Sequence[str] = ()) -> None:
    """Advance a run to the end of its budget and print its results; say how to resume it if it is interrupted."""
    import time

    started = time.perf_counter()
    try:
        # The run is there already: an interruption of these imports names the line that resumes it, too.
        from driftform.cli.progress import Progress
        from driftform.search import advance
        from driftform.search.jobs import WorkersLostError

        progress = Progress(run)
        try:
            with stop_at_signals():
                results = advance.advance_run(run, executor, progress)
        except WorkersLostError as error:
            raise WorkersLostError(f"{error}; {_describe_stop(run)}") from None
    except KeyboardInterrupt as stop:
        typer.echo(_describe_stop(run), err=True)
        raise typer.Exit(stop.args[0] if stop.args else 130) from None
    show_results(run, results, json, time.perf_counter() - started, [*warnings, *progress.warnings])


def show_results(
    run: "StoredRun", results: "list[Best]", json: bool, seconds: float = 0.0, warnings: Sequence[str] = ()
) -> None:
    """Print what a run has found, in words or as JSON. Raises WorkFailedError if a file could not be written."""
    from driftform.cli.output import print_json
    from driftform.errors import WorkFailedError

    overview, reach = (run.path / "figures" / f"{name}.svg" for name in ("overview", "reach"))
    if json:
        evaluations, failed = run.count()
        print_json(
            {
                "run": str(run.path),
                "seed": run.study.seed,
                "evaluations": evaluations,
                "failed": failed,
                "commonest_failure": run.describe_failures(),
                "seconds": seconds,
                "targets": {
                    best.target: {
                        **best.result,
                        "distance": best.result["nominal"],
                        **{
                            key: best.result.get("robust", {}).get(key)
                            for key in ("hit", "weighed", "baseline", "idle")
                        },
                        "robust": best.result.get("robust", {}),
                        "agent": str(best.agent),
                        "files": [str(path) for path in best.files],
                    }
                    for best in results
                },
                "warnings": list(warnings),
                "overview": str(overview),
                "reach": str(reach),
            }
        )
    else:
        _print_results(run, results, (overview, reach), seconds)
    problems = [problem for best in results for problem in best.problems]
    if problems:
        raise WorkFailedError(*problems)


@contextmanager
def stop_at_signals() -> Iterator[None]:
    """Let the signals by which batch systems and terminals end a program do what Ctrl-C does."""
    import signal

    def stop(number: int, _: object) -> None:
        raise KeyboardInterrupt(128 + number)

    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    # One that is ignored, as under nohup, stays so.
    caught = [number for name in names if signal.getsignal(number := getattr(signal, name)) is signal.SIG_DFL]
    for number in caught:
        signal.signal(number, stop)
    try:
        yield
    finally:
        for number in caught:
            signal.signal(number, signal.SIG_DFL)


def _describe_stop(run: "StoredRun") -> str:
    from driftform.errors import DriftformError

    try:
        evaluations, _ = run.count()
    except DriftformError as error:
        return f"stopped; {error}"
    return f"stopped after {evaluations} of {run.study.evaluations} evaluations; resume with: {run.resume_command}"


def _print_results(run: "StoredRun", results: "list[Best]", pictures: tuple[Path, Path], seconds: float) -> None:
    from driftform.cli.output import print_table, print_text
    from driftform.runs.wording import (
        describe_doubt,
        describe_worth,
        explain_columns,
        is_promised,
        list_cells,
        list_headings,
        summarise,
    )

    fitness, scenario = run.study.make_plugin("fitness"), run.study.scenario
    found = {best.target: best.result for best in results}
    promised = all(map(is_promised, found.values()))
    header = ("target", "x m", "y m", "z m", *list_headings(fitness, promised))
    header += () if promised else ("nominal mm",)
    print_table(
        header,
        (
            (
                target,
                *(f"{c:g}" for c in scenario.target_points()[target]),
                *list_cells(fitness, result, promised),
                *(() if promised else (f"{1000 * result['nominal']:.1f}",)),
            )
            for target, result in found.items()
        ),
        right=range(1, len(header)),
    )
    if results:
        print_text(summarise(fitness, found))
    if results and promised:
        print_text(explain_columns(fitness, scenario.robustness.checks))
        for text in filter(None, (*describe_worth(fitness, found), describe_doubt(fitness, found))):
            print_text(text)
    lost = {name: r["robust"]["failed"] for name, r in found.items() if promised and r["robust"]["failed"]}
    if lost:
        counts = ", ".join(f"{count} of {target}" for target, count in lost.items())
        print_text(f"disturbed flights that failed, and do not count: {counts}")
    evaluations, failed = run.count()
    print(f"{evaluations} evaluations ({failed} failed) in {seconds:.1f} s, seed {run.study.seed}")
    commonest = run.describe_failures()
    if commonest:
        print_text(f"failed most often ({commonest['count']} of {failed}): {commonest['reason']}")
    print(f"run:  {run.path}/")
    if results:
        print(f"      best/<target>/ ({', '.join(path.name for path in results[0].files)})")
    print(f"      figures/ ({', '.join(path.name for path in pictures)})")
    if results:
        print(f"next: driftform inspect {quote(f'{run.path}:{results[0].target}')}")
    print(f"      driftform report {quote(str(run.path))}")
