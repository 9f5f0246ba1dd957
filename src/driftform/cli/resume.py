"""``driftform resume``."""

from typing import Annotated

import typer

from driftform.cli.options import ExecutorName, Json, RunArgument, Scheduler, Workers


def resume(
    run: RunArgument,
    evaluations: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, help="Total budget, including finished evaluations (default: unchanged)."),
    ] = None,
    workers: Workers = None,
    executor: ExecutorName = None,
    scheduler: Scheduler = None,
    json: Json = False,
) -> None:
    """Continue a run where it stopped, however it stopped; the result is that of an undisturbed run.

    With a larger budget a complete run continues too: the result is that of a run that had it from the start.
    """
    from driftform.cli.running import advance_run, show_results
    from driftform.runs.run import Run

    with Run.resume(run, evaluations) as resumed:
        from driftform.search.advance import find_ended

        if (ended := find_ended(resumed)) is not None:
            show_results(resumed, ended, json)
            return
        from driftform.search.executors import open_executor

        with open_executor(resumed.study, executor, scheduler, workers) as place:
            advance_run(resumed, place, json)
