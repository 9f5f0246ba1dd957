"""``driftform plugins``."""

from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import typer

from driftform.cli.help import Command, make_group
from driftform.cli.options import FILE, Json, declare


def list_(json: Json = False) -> None:
    """List plugins and the commands that they add; for those that cannot be used, say why."""
    from driftform.cli.added import load_added
    from driftform.cli.output import print_json, print_table
    from driftform.plugins.registry import registry

    columns = ("seam", "name", "distribution", "version", "state")
    rows = [{c: getattr(row, c) for c in columns} for row in registry().contributions()]
    added = load_added()
    commands = [(name, added.owners[name], "ok") for name in sorted(added.commands)]
    commands += [(plugin.name, plugin, plugin.problem) for plugin in added.broken]
    for name, plugin, state in commands:
        rows.append(dict(zip(columns, ("commands", name, plugin.distribution, plugin.version, state), strict=True)))
    if json:
        print_json({"plugins": rows})
    else:
        print_table(columns, ([row[c] for c in columns] for row in rows))


app = make_group("List the installed plugins, show their options, and create a new one.", list_)


@app.command("show", cls=Command)
def show(name: Annotated[str, typer.Argument(metavar="NAME", help="Name of a plugin.")], json: Json = False) -> None:
    """Show what a plugin does, and its options with type, bounds, default and unit."""
    import inspect

    from driftform.cli.output import print_json, print_table
    from driftform.errors import InputError, did_you_mean
    from driftform.plugins.registry import registry
    from driftform.util.options import describe

    installed = registry().contributions()
    rows = [row for row in installed if row.name == name]
    if not rows:
        raise InputError(f"no plugin is named '{name}'{did_you_mean(name, [row.name for row in installed])}")
    found: list[dict[str, Any]] = []
    for row in rows:
        entry: dict[str, Any] = {k: getattr(row, k) for k in ("seam", "name", "distribution", "version", "state")}
        if row.cls is not None:
            # Not inspect.getdoc(), which may return the docstring of a base class.
            entry["summary"] = inspect.cleandoc(row.cls.__doc__ or "")
            entry["options"] = describe(row.cls.Options)
        found.append(entry)
    if json:
        print_json({"plugins": found})
        return
    for entry in found:
        print(f"{entry['seam'] or 'plugin'} {entry['name']}, from {entry['distribution']} {entry['version']}")
        if "options" not in entry:
            print(entry["state"])
            continue
        print(f"\n{entry['summary'] or 'It has no description.'}\n")
        if entry["options"]:
            columns = ("option", "type", "bounds", "default", "unit", "help")
            print_table(columns, ([str(option[c]) for c in columns] for option in entry["options"]))
        else:
            print("It has no options.")


@app.command("new", cls=Command)
@declare(FILE, "name", "seam", "out", "json")
def new(given: SimpleNamespace) -> None:
    """Create a plugin of your own to start from: a small distribution that installs, works, and passes its tests."""
    import shlex

    from driftform.cli.output import print_json
    from driftform.plugins.scaffold import list_files, list_installation, list_uses, make_names
    from driftform.util.files import check_new_directory, write_folder, write_text

    names = make_names(given.name, given.seam)
    folder = given.out if given.out is not None else Path(names.distribution)
    check_new_directory(folder)
    files = list_files(names)
    with write_folder(folder) as part:
        for path, text in files.items():
            write_text(part / path, text)
    install, test = list_installation()
    run = "uv run " if install.startswith("uv add ") else ""
    uses = (f"driftform plugins show {names.plugin}", "driftform scenarios check study.toml", *list_uses(names))
    following = [f"cd {shlex.quote(str(folder))}", install, test, *(run + line for line in uses)]
    if given.json:
        print_json(
            {
                "distribution": names.distribution,
                "package": names.package,
                "plugin": names.plugin,
                "seams": [given.seam],
                "folder": str(folder),
                "files": [str(folder / path) for path in files],
                "next": following,
            }
        )
        return
    print(f"{names.distribution}: {given.seam} '{names.plugin}', to be changed")
    for path in files:
        print(f"  {folder / path}")
    print("next:")
    for line in following:
        print(f"  {line}")
