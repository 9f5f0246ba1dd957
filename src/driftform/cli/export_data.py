"""``driftform export-data``."""

from types import SimpleNamespace

from driftform.cli.options import FILE, declare


@declare(FILE, "run", "format", "out", "trajectories", "json")
def export_data(given: SimpleNamespace) -> None:
    """Write a run as tables for pandas, polars and others: one row per evaluation.

    The run need not be finished: the tables hold what is stored when the command begins.
    """
    from driftform.cli.output import print_json
    from driftform.runs.run import StoredRun
    from driftform.runs.tables import COLUMNS, FOLDER, check_output, write_tables

    check_output(given.format, given.out)
    opened = StoredRun.open(given.run)
    rows = write_tables(opened, given.out, given.format, given.trajectories)
    folder = opened.path / FOLDER if given.out is None else given.out
    files = [{"table": table, "path": str(folder / f"{table}.{given.format}"), "rows": n} for table, n in rows.items()]
    columns = str(folder / COLUMNS)
    if given.json:
        print_json({"files": files, "columns": columns})
        return
    for file in files:
        print(f"{file['path']}: {file['rows']} rows")
    print(f"{columns}: unit and meaning of each column")
