"""The commands of plugins as commands of the parser."""

import inspect
from collections.abc import Callable
from typing import Annotated, Any, get_args

import typer

from driftform.cli.help import Command, Group
from driftform.cli.options import Json
from driftform.commands import Argument, CommandResult, InstalledGroup, Option, find_groups
from driftform.errors import DriftformError, InputError, WorkFailedError, describe_error


def list_groups() -> list[tuple[str, str]]:
    """Return name and help of each group of commands that plugins add; of a broken one the reason."""
    return [(name, _describe(group)) for name, group in find_groups().items()]


def make_group(name: str) -> Any:
    """Return the group of commands with this name, ``None`` if no plugin adds one.

    Raises
    ------
    InputError
        if the plugin cannot be imported, or two plugins claim the name.
    """
    installed = find_groups().get(name)
    if installed is None:
        return None
    try:
        group = installed.load()
    except InputError as error:
        raise InputError(f"command '{name}' ({installed.distribution}) is {error}") from None
    made = typer.Typer(
        cls=Group, help=group.help, no_args_is_help=True, add_completion=False, rich_markup_mode=None
    )
    made.callback()(lambda: None)
    for word, function in group.commands.items():
        made.command(word, cls=Command)(_wrap(f"{name} {word}", function))
    return typer.main.get_command(made)


def _describe(group: InstalledGroup) -> str:
    return group.load().help if group.state == "ok" else group.state


def _wrap(name: str, function: Callable[..., CommandResult]) -> Callable[..., None]:
    """Return a function that the parser can read: it calls the plugin's function, and prints what that returns."""

    def run(*, json: bool, **values: Any) -> None:
        from driftform.cli.output import print_json, print_table, print_text

        try:
            result = function(**values)
        except (DriftformError, OSError):
            raise
        except (Exception, SystemExit) as error:
            raise WorkFailedError(
                f"command '{name}' failed: {describe_error(error, with_place=True)}"
            ) from None
        if json:
            print_json(result.document)
            return
        for part in result.text:
            if isinstance(part, str):
                print_text(part)
            else:
                print_table(part.header, part.rows, part.right)

    parameters = [_translate(p) for p in inspect.signature(function, eval_str=True).parameters.values()]
    parameters.append(
        inspect.Parameter("json", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Json)
    )
    run.__doc__ = function.__doc__
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {p.name: p.annotation for p in parameters}
    return run


def _translate(parameter: inspect.Parameter) -> inspect.Parameter:
    kind, described = get_args(parameter.annotation)
    required = parameter.default is inspect.Parameter.empty
    match described:
        case Argument():
            info = typer.Argument(metavar=described.metavar, help=described.help, show_default=False)
        case Option():
            info = typer.Option(
                described.name,
                metavar=described.metavar or None,
                help=described.help,
                min=described.least,
                max=described.most,
                show_default=not required,
            )
        case _:
            raise TypeError(f"parameter {parameter.name} is annotated with neither Argument nor Option")
    return parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY, annotation=Annotated[kind, info])
