"""Help pages: plain text, which appears at once, with the whole first sentence of each command."""

import re
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from typing import Any

from typer import BadParameter, Context, Typer
from typer.core import TyperCommand, TyperGroup

from driftform.cli.options import Json
from driftform.cli.output import reserve_stdout

UsageError: Any = BadParameter.__mro__[1]
"""Base class of click's errors about options and arguments: newer typers have a private copy of click."""

DESIGN, FILES, NETWORKS, WORKSHOP = "Design", "Files, programs and plugins", "Water networks", "Workshop"
"""Groups of commands in ``driftform --help``; a command states its own by ``rich_help_panel``, as typer calls it."""

_MAX_SENTENCE = 1000
"""Characters after which a command's first sentence would be cut."""


class Group(TyperGroup):
    """A group that lists its commands with their whole first sentences."""

    default_panel = "Commands"
    """Group of commands that state none."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the name of each command and its first sentence, in the groups that commands state."""
        groups: dict[str, list[tuple[str, str]]] = {}
        commands = {**self.commands, **self.list_added()}
        for name, command in commands.items():
            panel = getattr(command, "rich_help_panel", None)
            title = panel if isinstance(panel, str) else self.default_panel
            groups.setdefault(title, []).append((name, command.get_short_help_str(_MAX_SENTENCE)))
        first = (DESIGN, FILES, NETWORKS, WORKSHOP)
        width = max(map(len, commands))
        for title in sorted(groups, key=lambda title: first.index(title) if title in first else len(first)):
            with formatter.section(title):
                formatter.write_dl([(f"{name:{width}}", text) for name, text in groups[title]])

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all commands, for the completion of a shell."""
        return [*super().list_commands(ctx), *self.list_added()]

    def list_added(self) -> Mapping[str, Any]:
        """Return commands by name that are added to the group when they are asked for."""
        return {}


def make_group(help: str, list_all: Callable[[bool], None]) -> Typer:
    """Return a group of commands that lists what there is if no command is named.

    Args:
        help: of the group.
        list_all: its command ``list``, a function of ``--json``.
    """
    group = Typer(cls=Group, help=help, invoke_without_command=True)

    @group.callback()
    def _default(ctx: Context, json: Json = False) -> None:
        if ctx.invoked_subcommand is None:
            with reserve_stdout() if json else nullcontext():
                list_all(json)

    group.command("list", cls=Command)(list_all)
    return group


class Command(TyperCommand):
    """A command whose arguments are called what their help calls them, without braces and types."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command; with ``--json`` its document is all that stdout gets."""
        with reserve_stdout() if ctx.params.get("json") else nullcontext():
            return super().invoke(ctx)

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return the words of the usage line."""
        return [re.sub(r"[{}]", "", piece) for piece in super().collect_usage_pieces(ctx)]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments and options, each with its help."""
        for title, kind in (("Arguments", "argument"), ("Options", "option")):
            shown = (one for one in self.get_params(ctx) if one.param_type_name == kind)
            records = [record for one in shown if (record := one.get_help_record(ctx)) is not None]
            if records:
                with formatter.section(title):
                    formatter.write_dl([(name.partition(" <")[0], text) for name, text in records])
