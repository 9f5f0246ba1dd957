"""``driftform export``."""

from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import typer

from driftform.cli.options import FILE, declare

if TYPE_CHECKING:
    from driftform.design.design import Design
    from driftform.types import WrittenFile

ANY_AGENT = "addB-tiltn-1-M-moveB-addB-tiltp-1-L-moveB"
"""The fit coupon is the same for all agents with a core."""


@declare(FILE, "agent", "format", "out", "kit", "coupon", "bed", "option", "settings", "json")
def export(given: SimpleNamespace) -> None:
    """Write the hull of an agent as files for printers and other programs; older files of the same name are replaced."""
    from driftform.cli.formats import open_exported, parse_formats
    from driftform.cli.output import print_files, print_json
    from driftform.errors import InputError, WorkFailedError
    from driftform.plugins.registry import registry
    from driftform.util.files import make_directory

    if given.agent is None and not given.coupon:
        raise InputError("AGENT is missing: name an agent, or write the fit coupon with --coupon")
    names = parse_formats(given.format, "exporter", "stl")
    whole = [
        name for name in names if given.kit and "kit" not in registry().find("exporter", name).Options.model_fields
    ]
    if whole and whole != names:
        typer.echo(f"note: not written: {', '.join(whole)}, which holds no parts of a kit", err=True)
        names = [name for name in names if name not in whole]
    asked = [*(given.option or ()), *(["coupon=true"] if given.coupon else [])]
    design = open_exported(given.agent or ANY_AGENT, names, given.kit, given.bed, asked, given.settings or ())
    make_directory(given.out)
    stem = "coupon" if given.coupon else design.name
    paths = {name: given.out / f"{stem}{design.study.make_exporter(name).suffix}" for name in names}
    # Several formats of a kit have the same assembly sheet.
    found: dict[str, WrittenFile] = {}
    for name, path in paths.items():
        try:
            found |= {file.path: file for file in design.export_files(name, path)}
        except WorkFailedError as error:
            raise WorkFailedError(f"{error}{_name_other_options(design, name) if given.kit else ''}") from None
    written = list(found.values())
    if not given.coupon and (note := design.describe_missing_kit(written)):
        typer.echo(f"note: {note}: write them with --kit", err=True)
    if given.json:
        print_json({"files": [{"format": w.format, "path": w.path, **w.facts} for w in written]})
        return
    # Of a folder with dozens of files, only the one to open is listed.
    print_files(written, given.out)
    for path in paths.values():
        if path.is_dir():
            print(f"{path}: {sum(path in Path(w.path).parents for w in written)} files")
    tables = [(key, fact) for file in written for key, fact in file.facts.items() if isinstance(fact, dict)]
    # All files of a kit have its facts.
    for place, (key, table) in enumerate(tables):
        if (key, table) not in tables[:place]:
            _print_table(key, table)


def _name_other_options(design: "Design", name: str) -> str:
    """The options of the kit with which the agent was simulated, where those of its exporter are others."""
    from json import dumps

    own = design.study.document["builder"].get("kit") or {}
    given = design.study.make_exporter(name).options.model_dump(mode="json")
    other = [f"--option {key}={dumps(value)}" for key, value in own.items() if given.get(key, value) != value]
    return f"; the agent was simulated with the [builder.kit] options {' '.join(other)}" if other else ""


def _print_table(title: str, table: dict[str, Any]) -> None:
    """Facts of a file that take more than a line: single ones, and rows that have the same facts each."""
    from driftform.cli.output import shorten

    print(f"\n{title}")
    for key, value in table.items():
        if value in ([], (), "", None):
            continue
        if isinstance(value, dict) and {"kind", "x_mm", "why"} <= value.keys():
            print(f"  {key}: {value['kind']} at x {value['x_mm']:+.4g} mm: {value['why']}")
        elif isinstance(value, dict):
            print(f"  {key}: {', '.join(f'{k} {shorten(v)}' for k, v in value.items())}")
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            rows = [list(value[0]), *([shorten(row[k]) for k in value[0]] for row in value)]
            widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
            print(f"  {key}")
            for row in rows:
                cells = (f"{cell:{'<' if not i else '>'}{widths[i]}}" for i, cell in enumerate(row))
                print(f"    {'  '.join(cells)}".rstrip())
        else:
            print(f"  {key}: {shorten(value)}")
