"""The commands that plugins add, by the hook ``driftform_commands``."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import typer

from driftform.cli.help import Command, Group, UsageError
from driftform.errors import DriftformError, InputError, WorkFailedError, describe_error
from driftform.plugins.discovery import PluginModule, find_modules

BROUGHT_BY: Mapping[str, str] = {
    "body": "driftform-frusta",
    "calibrate": "driftform-calibration",
    "check": "driftform-kit",
    "drop": "driftform-calibration",
    "export-flow": "driftform-tees",
    "network": "driftform[networks]",
    "reproduce": "driftform-paper",
    "ros": "driftform[ros]",
    "studio": "driftform[studio]",
    "trim": "driftform-kit",
}
"""What to install for the commands that driftform's own plugins add."""


class AddedCommand(Command):
    """A command of a plugin: an error of the plugin becomes one line."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command. Raises WorkFailedError for any error that is not meant for users."""
        try:
            return super().invoke(ctx)
        except (DriftformError, OSError, typer.Exit, typer.Abort, UsageError):
            raise
        except (Exception, SystemExit) as error:
            name = ctx.command_path.partition(" ")[2]
            raise WorkFailedError(f"command '{name}' failed: {describe_error(error, with_place=True)}") from None


@dataclass(frozen=True)
class Added:
    """What plugins add: commands by name, their plugins, and one line per plugin or command that is unavailable."""

    commands: Mapping[str, Any]
    owners: Mapping[str, PluginModule]
    problems: Mapping[str, str]
    broken: Sequence[PluginModule]
    """Plugins whose hook for commands raises, with the reason as their problem."""


@cache
def load_added() -> Added:
    """Return the commands that plugins add; what fails is left out, with the reason."""
    commands: dict[str, Any] = {}
    owners: dict[str, PluginModule] = {}
    problems: dict[str, str] = {}
    broken: list[PluginModule] = []
    for plugin in find_modules():
        if plugin.problem:
            problems[plugin.distribution] = f"{plugin.distribution} is {plugin.problem}"
            continue
        try:
            hook = plugin.find_hook("driftform_commands")
            made = {} if hook is None else make_commands(hook)
        except (Exception, SystemExit) as error:
            broken.append(replace(plugin, problem=f"unavailable: {describe_error(error)}"))
            problems[plugin.distribution] = f"{plugin.distribution} is {broken[-1].problem}"
            continue
        for name, command in made.items():
            if name in owners:
                problems[name] = (
                    f"{owners[name].distribution} and {plugin.distribution} claim it; uninstall one of them"
                )
                commands.pop(name, None)
            else:
                owners[name], commands[name] = plugin, command
    return Added(commands, owners, problems, broken)


def find_added(name: str) -> Any:
    """Return the command that a plugin adds under a name, ``None`` if no plugin is known to add it.

    Raises InputError if two plugins claim the name, or a plugin that may add it is missing or broken.
    """
    added = load_added()
    if name in added.commands:
        return added.commands[name]
    if name in added.problems:
        raise InputError(f"command '{name}' is unavailable: {added.problems[name]}")
    package = BROUGHT_BY.get(name)
    if package is None and added.broken:
        reasons = "; ".join(added.problems[plugin.distribution] for plugin in added.broken)
        raise InputError(f"no command is named '{name}'; {reasons}")
    if package is None:
        return None
    distribution = package.replace("[", "-").removesuffix("]")
    if distribution in added.problems:
        raise InputError(f"command '{name}': {added.problems[distribution]}")
    extra = package.partition("[")[2].removesuffix("]")
    in_clone = f"uv sync --extra {extra}, or " if extra else ""
    raise InputError(f"command '{name}' is not installed; run: {in_clone}pip install \"{package}\"")


def make_app(hook: Callable[[typer.Typer], None], cls: type[Group] = Group) -> typer.Typer:
    """Return an application with the commands that a hook adds, which look and fail like those of driftform."""
    app = typer.Typer(cls=cls, add_completion=False, rich_markup_mode=None)
    app.callback()(lambda: None)
    hook(app)
    _apply_style(app)
    return app


def make_commands(hook: Callable[[typer.Typer], None]) -> dict[str, Any]:
    """Return the commands that a hook adds, by name."""
    return dict(typer.main.get_group(make_app(hook)).commands)


def _apply_style(app: typer.Typer) -> None:
    """Let the commands of a plugin look and fail like those of driftform."""
    for command in app.registered_commands:
        command.cls = AddedCommand
    for group in app.registered_groups:
        if group.typer_instance is not None:
            group.cls, group.typer_instance.info.cls = Group, Group
            _apply_style(group.typer_instance)
