"""``driftform scenarios``."""

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import typer

from driftform.cli.help import Command, make_group
from driftform.cli.options import FILE, Json, declare
from driftform.errors import InputError


def list_(json: Json = False) -> None:
    """List the built-in scenarios."""
    import tomllib

    from driftform.cli.output import print_json, print_table
    from driftform.study.sources import read_scenarios

    rows = [
        {"name": name, "title": document.get("title", ""), "targets": len(document.get("targets", {}))}
        for name, document in ((name, tomllib.loads(text)) for name, text in read_scenarios().items())
    ]
    if json:
        print_json({"scenarios": rows})
    else:
        print_table(
            ("name", "targets", "title"), ((r["name"], str(r["targets"]), r["title"]) for r in rows), right=(1,)
        )


app = make_group("List and show the built-in scenarios as TOML to copy, and check your own.", list_)


@app.command("show", cls=Command)
def show(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of a built-in scenario.")], json: Json = False
) -> None:
    """Print a built-in scenario: copy it, or start a study of your own with base = "NAME"."""
    import tomllib

    from driftform.cli.output import print_json
    from driftform.errors import did_you_mean
    from driftform.study.sources import read_scenarios

    texts = read_scenarios()
    if name not in texts:
        raise InputError(f"no built-in scenario is named '{name}'{did_you_mean(name, texts)}")
    if json:
        print_json({"name": name, "scenario": tomllib.loads(texts[name])})
    else:
        print(texts[name], end="")


@app.command("check", cls=Command)
@declare(FILE, "file", "picture", "settings", "json")
def check(given: SimpleNamespace) -> None:
    """Check a study without running it: list its errors, or show its contents and warnings."""
    from driftform.cli.output import print_json, print_text
    from driftform.errors import escape_controls
    from driftform.interfaces import NAMED
    from driftform.study import SELECTED, load_study
    from driftform.util.files import check_directory, write_text

    try:
        study = load_study(given.file, given.settings or ())
    except InputError as error:
        if given.picture is not None:
            _draw_faults(given.file, given.settings or (), given.picture, error)
        raise
    warnings = study.list_warnings()
    if study.scenario.targets:
        study.make_strategy()
    document, scenario = study.document, study.scenario
    if given.picture is not None:
        from driftform.figures.pipe import pipe_svg

        check_directory(given.picture.parent, "--picture")
        write_text(given.picture, pipe_svg(scenario, document.get("title", "") or given.file, notes=warnings))
    found = {
        "file": given.file,
        "title": document.get("title", ""),
        "targets": dict(scenario.targets),
        "pipe": len(scenario.pipe.layout.parts),
        "outlets": [outlet.name for outlet in scenario.pipe.layout.outlets],
        "flow": scenario.flow.kind,
        "plugins": {seam: document[seam]["use"] for seam in SELECTED},
        "options": {seam: list(document[seam]) for seam in NAMED},
        "evaluations": study.evaluations,
        "formats": list(study.run.formats),
        "warnings": warnings,
        "picture": None if given.picture is None else str(given.picture),
    }
    if given.json:
        print_json(found)
        return
    verdict = f"is valid, with {len(warnings)} warning{'s' * (len(warnings) != 1)}" if warnings else "is sound"
    print_text(f"{given.file} {verdict}" + (f": {escape_controls(found['title'])}" if found["title"] else ""))
    targets = f"{len(scenario.targets)}: {', '.join(scenario.targets)}" if scenario.targets else "none"
    outlets = found["outlets"]
    pipe = f"{found['pipe']} part{'s' * (found['pipe'] != 1)}" if found["pipe"] else "none: open water"
    if found["pipe"]:
        pipe += f", bore {2000 * scenario.pipe.layout.inlet.radius:g} mm"
    rows = {
        "targets": targets,
        "pipe": pipe + (f"; outlets {', '.join(outlets)}" if len(outlets) > 1 else ""),
        "flow": found["flow"],
        **found["plugins"],
        **{seam: f"options of {', '.join(names)}" for seam, names in found["options"].items() if names},
        "evaluations": str(study.evaluations),
        "files": ", ".join(study.run.formats),
    }
    width = max(map(len, rows))
    for name, value in rows.items():
        print(f"  {name:{width}}  {value}")
    for warning in warnings:
        print_text(f"warning: {warning}")
    if given.picture is not None:
        print(f"picture: {given.picture}")


def _draw_faults(file: str, settings: Sequence[str], picture: Path, fault: InputError) -> None:
    """Draw the pipe of a study that is wrong, with the places that lie outside; nothing if even the pipe is wrong."""
    import numpy as np

    from driftform.figures.pipe import pipe_svg
    from driftform.study import load_study
    from driftform.study.sources import merge_source, parse_setting, read_sources
    from driftform.util.files import check_directory, write_text

    check_directory(picture.parent, "--picture")
    document: dict[str, Any] = {}
    for layer in (*read_sources(file), *map(parse_setting, settings)):
        document = merge_source(document, layer)
    points = {name: value for name, value in document.get("targets", {}).items() if _is_point(value)}
    for released in ([], ["release.position=[0, 0, 0]"]):
        try:
            scenario = load_study(file, [*settings, "targets={}", *released]).scenario
        except InputError:
            continue
        if released and _is_point(document["release"].get("position")):
            release = scenario.release.model_copy(update={"position": document["release"]["position"]})
            points["release"] = scenario.model_copy(update={"release": release}).release_position()
        sound = {name: point for name, point in points.items() if scenario.pipe.contains(tuple(point))}
        wrong = [(name, np.array(point)) for name, point in points.items() if name not in sound]
        scenario, title = scenario.model_copy(update={"targets": sound}), document.get("title", "") or file
        write_text(picture, pipe_svg(scenario, title, wrong, list(map(str, fault.args))))
        return


def _is_point(value: object) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(isinstance(v, int | float) for v in value)
