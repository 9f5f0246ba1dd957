"""The command line: one file for each command, and nothing heavy imported before a command runs."""

from driftform.cli.app import app

__all__ = ["app", "main"]


def main() -> None:
    """Run the command line."""
    app(prog_name="driftform")
