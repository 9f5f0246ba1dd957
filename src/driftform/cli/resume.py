"""``driftform resume``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from driftform.cli.options import ExecutorName, Json, Scheduler, Workers

if TYPE_CHECKING:
    from driftform.runs.store import Store


def resume(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    evaluations: Annotated[
        int | None,
        typer.Option(
            "--evaluations",
            metavar="N",
            min=1,
            help="Flights in all, those that the run has included; as before by default.",
        ),
    ] = None,
    workers: Workers = None,
    executor: ExecutorName = None,
    scheduler: Scheduler = None,
    json: Json = False,
) -> None:
    """Go on with a run where it stopped, however it stopped; the result is that of an undisturbed run.

    With a larger budget a run that is complete goes on too: the result is that of a run which had it from the start.
    """
    from driftform.cli.evolve import carry_out
    from driftform.cli.executors import open_executor
    from driftform.runs.directory import check_run, lock_run, write_resolved
    from driftform.runs.store import Store
    from driftform.study import Document, load_study

    database = check_run(run)
    with lock_run(run):
        # Only read until all is checked: what is refused leaves the run as it was.
        with Store.open(database, read_only=True) as store:
            document = store.read_study()
            study = load_study(Document(str(database), document), run={"evaluations": evaluations})
            if evaluations is not None:
                _check_budget(run, store, evaluations)
        with (
            open_executor(study, executor, scheduler, workers) as place,
            Store.open(database, check=False) as store,
        ):
            if evaluations is not None:
                document = {**document, "run": {**document.get("run", {}), "evaluations": evaluations}}
                store.replace_study(document)
            # The database is what counts: an interruption before this line is made good by the next call.
            write_resolved(run, document)
            carry_out(run, study, store, place, json)


def _check_budget(run: Path, store: "Store", evaluations: int) -> None:
    from driftform.errors import InputError

    # Evaluations are stored as they come: what is there may have gaps below the last of them.
    if evaluations <= store.last_index():
        raise InputError(
            f"--evaluations {evaluations} is less than {run} holds already; give at least {store.last_index() + 1}"
        )
