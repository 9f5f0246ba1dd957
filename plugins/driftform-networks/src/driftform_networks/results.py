"""What the commands print and write of a passage: lines, tables, maps."""

from pathlib import Path
from typing import Any

from driftform.commands import CommandResult, TextTable
from driftform.errors import InputError
from driftform.figures.files import write_picture
from driftform.util.files import check_directory, make_directory, write_text
from driftform_networks.map import format_time, passage_svg
from driftform_networks.passage import Passage

MOST_ROWS = 12
"""Rows of a table on the screen; all are in the files of ``--tables``, and in the JSON document."""


def check_files(map: Path | None, tables: Path | None) -> None:
    """Refuse files that cannot be written, before work that takes time.

    Raises
    ------
    InputError
        if a directory cannot be written to, or the map is not an SVG file.
    """
    if map is not None:
        if map.suffix != ".svg":
            raise InputError(f"--map {map}: a map is an SVG file: its name must end in .svg")
        check_directory(map.parent, "--map")
    if tables is not None:
        check_directory(tables, "--tables")


def present_passage(
    passage: Passage, title: str, map: Path | None, tables: Path | None, more: dict[str, Any] | None = None
) -> CommandResult:
    """Write the files of a passage, and return what a command prints of it."""
    files = [*write_map(passage_svg(passage, title), map)] if map is not None else []
    if tables is not None:
        files += write_tables(passage, tables)
    document = {**passage.as_document(), **(more or {}), "files": [str(file) for file in files]}
    length = passage.network.length[passage.reachable].sum() / 1000
    text: list[str | TextTable] = [title, *_table_nodes(passage), *_table_ends(passage)]
    text.append(f"sees {100 * passage.coverage:.1f} % of the {length:.1f} km that its water reaches")
    text += [f"wrote {file}" for file in files]
    return CommandResult(document, text)


def write_map(picture: str, path: Path) -> tuple[Path, ...]:
    """Write a map, and return the paths of its files."""
    make_directory(path.parent, "--map")
    return write_picture(path, picture)


def write_tables(passage: Passage, folder: Path) -> list[Path]:
    """Write the tables of a passage as CSV files, and return their paths."""
    make_directory(folder, "--tables")
    written = []
    for name, columns in (
        ("nodes", passage.node_table()),
        ("links", passage.link_table()),
        ("ends", passage.end_table()),
    ):
        path = folder / f"{name}.csv"
        write_text(path, format_csv(columns))
        written.append(path)
    return written


def format_csv(columns: dict[str, list[Any]]) -> str:
    """Return columns as CSV text."""
    import csv
    import io

    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return buffer.getvalue()


def _table_nodes(passage: Passage) -> list[str | TextTable]:
    network = passage.network
    order = sorted(
        (
            node
            for node in range(len(network.nodes))
            if passage.probability[node] > 1e-6 and node != passage.release
        ),
        key=lambda node: (-passage.probability[node], passage.age[node]),
    )
    rows = []
    for node in order[:MOST_ROWS]:
        row = [network.nodes[node], f"{100 * passage.probability[node]:.2f}", format_time(passage.age[node])]
        if len(passage.quantiles):
            low, _, high = passage.quantiles[node]
            row.append(f"{format_time(low)} to {format_time(high)}")
        rows.append(row)
    header = ["node", "probability %", "mean age"] + (
        ["9 of 10 arrive after"] if len(passage.quantiles) else []
    )
    left = [f"and {len(order) - MOST_ROWS} more nodes"] if len(order) > MOST_ROWS else []
    return [TextTable(header, rows, right=(1,)), *left]


def _table_ends(passage: Passage) -> list[str | TextTable]:
    shown = [end for end in passage.ends if end.probability >= 5e-5][:MOST_ROWS]
    rows = [[end.kind, end.place, f"{100 * end.probability:.2f}", end.reason] for end in shown]
    left = [f"and {len(passage.ends) - len(shown)} more ends"] if len(passage.ends) > len(shown) else []
    return [TextTable(("ends by", "place", "probability %", "reason"), rows, right=(2,)), *left]
