"""``driftform resume``."""

from types import SimpleNamespace

from driftform.cli.options import FILE, declare


@declare(FILE, "run", "evaluations", "workers", "scheduler", "json")
def resume(given: SimpleNamespace) -> None:
    """Continue a run that was interrupted; the result equals that of an uninterrupted run.

    A finished run continues with a larger --evaluations; the result equals that of a run with this number from the start.
    """
    from driftform.cli.running import advance_run, show_results
    from driftform.runs.run import StoredRun

    with StoredRun.resume(given.run, given.evaluations) as resumed:
        from driftform.search.advance import find_ended

        if (ended := find_ended(resumed)) is not None:
            show_results(resumed, ended, given.json)
            return
        from driftform.search.executors import open_executor

        with open_executor(resumed.study, given.scheduler, given.workers) as place:
            advance_run(resumed, place, given.json)
