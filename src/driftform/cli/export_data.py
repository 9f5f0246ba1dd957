"""``driftform export-data``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from driftform.cli.options import Json

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from driftform.runs.store import Record, Store
    from driftform.study import Study

FOLDER = "data"
COLUMNS = "columns.json"

CHUNK = 64
"""Evaluations that are read at a time: nobody who writes has to wait for a reader, and logs stay short."""


def export_data(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    format: Annotated[
        str, typer.Option("--format", metavar="NAME", help="csv, or parquet (needs pyarrow).")
    ] = "csv",
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="New directory for the files; by default RUN/data."),
    ] = None,
    trajectories: Annotated[
        bool,
        typer.Option("--trajectories", help="The samples of all flights too, hundreds for each."),
    ] = False,
    json: Json = False,
) -> None:
    """Write a run as tables for pandas, polars and others: one row for each evaluation.

    Also while the run goes on: then there is what was stored when it began.
    """
    from driftform.cli.output import print_json
    from driftform.runs.directory import check_run
    from driftform.runs.store import Store
    from driftform.study import Document, load_study
    from driftform.tables.files import FORMATS, check_format
    from driftform.util.files import write_together

    _check_name(format, list(FORMATS))
    database = check_run(run)
    check_format(format)
    folder = run / FOLDER if out is None else _new(out)
    older = {f"{table}.{suffix}" for table in ("evaluations", "trajectories") for suffix in FORMATS}
    with Store.open(database, read_only=True) as store:
        study = load_study(Document(str(database), store.read_study()))
        with write_together(folder, older) as part:
            rows = _write(part, study, store, format, trajectories)
    files = [
        {"table": table, "path": str(folder / f"{table}.{format}"), "rows": n} for table, n in rows.items()
    ]
    columns = str(folder / COLUMNS)
    if json:
        print_json({"files": files, "columns": columns})
        return
    for file in files:
        print(f"{file['path']}: {file['rows']} rows")
    print(f"{columns}: unit and meaning of each column")


def _write(part: Path, study: "Study", store: "Store", format: str, trajectories: bool) -> dict[str, int]:
    """Write the tables and what their columns mean into a directory; return how many rows each has."""
    from driftform import __version__
    from driftform.runs.tables import describe_tables, evaluation_batches, sample_batches
    from driftform.tables.columns import SAMPLE_COLUMNS, evaluation_columns
    from driftform.tables.files import FORMATS
    from driftform.util.progress import count_progress

    targets = study.scenario.target_names
    tables = {"evaluations": evaluation_columns(targets)}
    write, rows, seen = FORMATS[format], {}, set[int]()

    def noted(records: "Iterable[Record]") -> "Iterator[Record]":
        for record in records:
            seen.add(record.index)
            yield record

    with count_progress("evaluations") as progress:
        records = _counted(noted(_records(store, targets)), progress, store.count())
        path = part / f"evaluations.{format}"
        rows["evaluations"] = write(path, tables["evaluations"], evaluation_batches(study, records))
    if trajectories:
        tables["trajectories"] = SAMPLE_COLUMNS
        with count_progress("flights") as progress:
            # What has come since has no row among the evaluations.
            known = (record for record in _records(store, targets) if record.index in seen)
            path = part / f"trajectories.{format}"
            batches = sample_batches(_counted(known, progress, len(seen)))
            rows["trajectories"] = write(path, SAMPLE_COLUMNS, batches)
    facts = {"driftform": __version__, "seed": study.seed}
    (part / COLUMNS).write_text(describe_tables(tables, facts), encoding="utf-8")
    return rows


def _check_name(name: str, known: list[str]) -> None:
    from driftform.errors import InputError, did_you_mean

    if name not in known:
        raise InputError(f"--format {name}: no such format of tables{did_you_mean(name, known)}")


def _new(out: Path) -> Path:
    from driftform.errors import InputError

    if out.exists() and not out.is_dir():
        raise InputError(f"{out} is a file; choose another --out")
    if out.is_dir() and any(out.iterdir()):
        raise InputError(f"{out} is not an empty directory; choose another --out")
    return out


def _records(store: "Store", targets: tuple[str, ...]) -> "Iterator[Record]":
    for first in range(0, store.last_index() + 1, CHUNK):
        yield from list(store.read_records(targets, first, CHUNK))


def _counted(
    records: "Iterable[Record]", progress: "Callable[[int, int], None]", total: int
) -> "Iterator[Record]":
    for number, record in enumerate(records, start=1):
        yield record
        # More may have come meanwhile.
        progress(number, max(number, total))
