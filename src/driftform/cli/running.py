"""What ``evolve`` and ``resume`` share: advance a run, and print what it found."""

from collections.abc import Sequence
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from driftform.runs.run import Run
    from driftform.search.jobs import Executor
    from driftform.search.results import Best


def advance_run(run: "Run", executor: "Executor", json: bool, warnings: Sequence[str] = ()) -> None:
    """Advance a run to the end of its budget and print its results; say how to resume it if it is interrupted."""
    import time

    from driftform.cli.output import print_json
    from driftform.errors import WorkFailedError

    started = time.perf_counter()
    try:
        # The run is there already: an interruption of these imports names the line that resumes it, too.
        from driftform.cli.progress import Progress
        from driftform.search.advance import advance_run as search
        from driftform.search.jobs import WorkersLostError

        progress = Progress(run)
        results = search(run, executor, progress)
    except KeyboardInterrupt:
        typer.echo(_describe_stop(run), err=True)
        raise typer.Exit(130) from None
    except WorkersLostError as error:
        raise WorkersLostError(f"{error}; {_describe_stop(run)}") from None
    seconds = time.perf_counter() - started
    fitness = run.study.make_plugin("fitness")
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
                        "fitness": best.fitness,
                        "error_percent": best.error_percent,
                        "verdict": fitness.judge(best.fitness),
                        "distance": best.nominal,
                        "nominal": best.nominal,
                        "median": best.median,
                        "p90": best.p90,
                        "robust": best.robust,
                        "agent": str(best.agent),
                        "files": [str(path) for path in best.files],
                    }
                    for best in results
                },
                "warnings": [*warnings, *progress.warnings],
                "overview": str(overview),
                "reach": str(reach),
            }
        )
    else:
        _print_results(run, results, (overview, reach), seconds)
    problems = [problem for best in results for problem in best.problems]
    if problems:
        raise WorkFailedError(*problems)


def _describe_stop(run: "Run") -> str:
    from driftform.errors import DriftformError

    try:
        evaluations, _ = run.count()
    except DriftformError as error:
        return f"stopped; {error}"
    return (
        f"stopped after {evaluations} of {run.study.evaluations} evaluations; "
        f"resume with: {run.resume_command}"
    )


def _format_share(share: float | None) -> str:
    return "-" if share is None else f"{100 * share:.0f}"


def _summarise_misses(results: "list[Best]") -> str:
    """Return in one line how far the promised misses reach."""
    from statistics import median

    from driftform.cli.output import format_miss

    reach = {best.target: float("inf") if best.p90 is None else best.p90 for best in results}
    worst = max(reach, key=lambda target: reach[target])
    return (
        f"9 of 10 disturbed flights pass their target within {format_miss(median(reach.values()))} mm in the median over "
        f"targets, within {format_miss(reach[worst])} mm at worst ({worst})"
    )


def _print_results(run: "Run", results: "list[Best]", pictures: tuple[Path, Path], seconds: float) -> None:
    from driftform.cli.output import format_miss, print_table, print_text
    from driftform.runs.wording import list_cells, list_headings, summarise

    fitness = run.study.make_plugin("fitness")
    promised = any(best.robust for best in results)
    misses = ("nominal mm", "median mm", "90 % mm") if promised else ("nominal mm",)
    shared = (fitness.share,) if promised and fitness.share else ()
    header = ("target", "x m", "y m", "z m", *list_headings(fitness), *misses, *shared)
    print_table(
        header,
        (
            (
                best.target,
                *(f"{c:g}" for c in run.study.scenario.target_points()[best.target]),
                *list_cells(fitness, best.fitness),
                f"{1000 * best.nominal:.1f}",
                *((format_miss(best.median), format_miss(best.p90)) if promised else ()),
                *(_format_share(best.robust.get("reached")) for _ in shared),
            )
            for best in results
        ),
        right=range(1, len(header)),
    )
    if results:
        print_text(summarise(fitness, {best.target: best.fitness for best in results}))
    if shared:
        print_text(
            f"{fitness.share}: the share of {run.study.scenario.robustness.checks} flights under fresh disturbed conditions "
            f"that reach the target, with {fitness.goal}"
        )
    elif promised:
        print_text(_summarise_misses(results))
    lost = {best.target: best.robust["failed"] for best in results if best.robust.get("failed")}
    if lost:
        counts = ", ".join(f"{count} of {target}" for target, count in lost.items())
        print_text(f"disturbed flights that failed, and do not count: {counts}")
    if promised and not shared:
        print_text(
            "nominal: the undisturbed flight; median and 90 %: half, and 9 of 10, of "
            f"{run.study.scenario.robustness.checks} flights under fresh disturbed conditions miss by less"
        )
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
