"""Help pages: plain text, which appears at once, with the first sentence of each command whole."""

from typing import Any

from typer.core import TyperGroup

_LONGEST = 1000
"""Letters after which a command's first sentence would be cut."""


class Group(TyperGroup):
    """Commands that are listed with all of their first sentences."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the name of each command, and what it does."""
        rows = [(name, command.get_short_help_str(_LONGEST)) for name, command in self.commands.items()]
        with formatter.section("Commands"):
            formatter.write_dl(rows)
