"""``driftform resume``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli.options import Json, Workers


def resume(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    workers: Workers = None,
    json: Json = False,
) -> None:
    """Go on with a run where it stopped, however it stopped; the result is that of an undisturbed run."""
    from driftform.cli.evolve import carry_out
    from driftform.run_directory import check_run, locked
    from driftform.store import Store
    from driftform.study import Document, load_study

    database = check_run(run)
    with locked(run), Store.open(database) as store:
        study = load_study(Document(str(database), store.study()))
        carry_out(run, study, store, workers, json)
