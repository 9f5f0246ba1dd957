"""``driftform export-data``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli.options import Json, RunArgument, make_option


def export_data(
    run: RunArgument,
    format: Annotated[str, make_option("NAME", "Format of the tables: csv, or parquet (needs pyarrow).")] = "csv",
    out: Annotated[Path | None, make_option("DIR", "New directory for the files; by default RUN/data.")] = None,
    trajectories: Annotated[
        bool, typer.Option("--trajectories", help="Write the samples of all flights too, hundreds per flight.")
    ] = False,
    json: Json = False,
) -> None:
    """Write a run as tables for pandas, polars and others: one row per evaluation.

    The run need not be finished: the tables hold what is stored when the command begins.
    """
    from driftform.cli.output import print_json
    from driftform.runs.run import StoredRun
    from driftform.runs.tables import COLUMNS, FOLDER, check_output, write_tables

    check_output(format, out)
    opened = StoredRun.open(run)
    rows = write_tables(opened, out, format, trajectories)
    folder = opened.path / FOLDER if out is None else out
    files = [{"table": table, "path": str(folder / f"{table}.{format}"), "rows": n} for table, n in rows.items()]
    columns = str(folder / COLUMNS)
    if json:
        print_json({"files": files, "columns": columns})
        return
    for file in files:
        print(f"{file['path']}: {file['rows']} rows")
    print(f"{columns}: unit and meaning of each column")
