"""``driftform scenarios``."""

from typing import Annotated

import typer

from driftform.cli.options import Json

app = typer.Typer(help="The built-in scenarios, as TOML to copy.", invoke_without_command=True)


@app.callback()
def _default(ctx: typer.Context, json: Json = False) -> None:
    if ctx.invoked_subcommand is None:
        list_(json)


@app.command("list")
def list_(json: Json = False) -> None:
    """List the built-in scenarios."""
    import tomllib

    from driftform.cli.output import print_json, print_table
    from driftform.layers import builtin_scenarios

    rows = [
        {"name": name, "title": document.get("title", ""), "targets": len(document.get("targets", {}))}
        for name, document in ((name, tomllib.loads(text)) for name, text in builtin_scenarios().items())
    ]
    if json:
        print_json({"scenarios": rows})
    else:
        print_table(
            ("name", "targets", "title"),
            ((r["name"], str(r["targets"]), r["title"]) for r in rows),
            right=(1,),
        )


@app.command("show")
def show(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="Name of a built-in scenario.", show_default=False)
    ],
    json: Json = False,
) -> None:
    """Print a built-in scenario: copy it, or start a study of your own with base = "NAME"."""
    import tomllib

    from driftform.cli.output import print_json
    from driftform.errors import InputError, did_you_mean
    from driftform.layers import builtin_scenarios

    texts = builtin_scenarios()
    if name not in texts:
        raise InputError(f"no built-in scenario is named '{name}'{did_you_mean(name, texts)}")
    if json:
        print_json({"name": name, "scenario": tomllib.loads(texts[name])})
    else:
        print(texts[name], end="")
