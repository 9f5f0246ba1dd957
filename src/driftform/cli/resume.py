"""``driftform resume``."""

from typing import Annotated

from driftform.cli.options import Json, RunArgument, Scheduler, Workers, make_option


def resume(
    run: RunArgument,
    evaluations: Annotated[
        int | None, make_option("N", "Total number of flights, including finished ones; by default unchanged.", min=1)
    ] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    json: Json = False,
) -> None:
    """Continue a run that was interrupted; the result equals that of an uninterrupted run.

    A finished run continues with a larger --evaluations; the result equals that of a run with this number from the start.
    """
    from driftform.cli.running import advance_run, show_results
    from driftform.runs.run import StoredRun

    with StoredRun.resume(run, evaluations) as resumed:
        from driftform.search.advance import find_ended

        if (ended := find_ended(resumed)) is not None:
            show_results(resumed, ended, json)
            return
        from driftform.search.executors import open_executor

        with open_executor(resumed.study, scheduler, workers) as place:
            advance_run(resumed, place, json)
