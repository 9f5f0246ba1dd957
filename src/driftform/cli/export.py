"""``driftform export``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli.options import Agent, Json, Settings


def export(
    agent: Agent,
    format: Annotated[
        str, typer.Option("--format", metavar="NAME[,NAME...]", help="Formats, see 'driftform plugins'.")
    ] = "stl",
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Directory for the files.")] = Path(
        "parts"
    ),
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Write an agent's hull as files for printers and other programs; an older file of the name is replaced."""
    from driftform.cli.agents import open_agent
    from driftform.cli.output import print_json
    from driftform.errors import InputError
    from driftform.files import make_directory
    from driftform.registry import registry

    names = [name.strip() for name in format.split(",") if name.strip()]
    if not names:
        raise InputError("--format is empty; name at least one, such as stl")
    for name in names:
        try:
            registry().find("exporter", name)
        except InputError as error:
            raise InputError(f"--format {name}: {error}") from None
    opened = open_agent(agent, settings=settings or ())
    make_directory(out)
    exporters = [opened.study.exporter(name) for name in names]
    specimen = opened.specimen()
    written = [
        file
        for exporter in exporters
        for file in exporter.write(specimen, out / f"{opened.name}{exporter.suffix}")
    ]
    if json:
        print_json({"files": [{"format": w.format, "path": w.path, **w.facts} for w in written]})
        return
    for w in written:
        facts = ", ".join(f"{key} {_short(value)}" for key, value in w.facts.items())
        print(f"{w.path}: {facts}" if facts else w.path)


def _short(value: object) -> str:
    if isinstance(value, list | tuple):
        return " x ".join(_short(item) for item in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)
