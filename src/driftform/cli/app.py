"""The commands, put together; errors of the user become one line and an exit code."""

import errno
import os
import re
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import Annotated, Any

import typer

from driftform import __version__
from driftform.cli import (
    compare,
    evolve,
    export,
    export_data,
    export_flight,
    inspect,
    pick,
    plugins,
    report,
    resume,
    sample,
    scenarios,
    simulate,
    watch,
)
from driftform.cli.help import DESIGN, FILES, Command, Group, UsageError
from driftform.errors import DriftformError, escape_controls
from driftform.util.progress import show_progress


class Commands(Group):
    """The commands of driftform. An error of the input or of the work becomes a line on stderr and an exit code.

    0 done, 1 the work failed, 2 the input is wrong, 130 interrupted.
    """

    default_panel = FILES

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command of the core, or one that a plugin adds under a name."""
        found = super().get_command(ctx, cmd_name)
        if found is not None:
            return found
        from driftform.cli.added import find_added

        return find_added(cmd_name)

    def list_added(self) -> Mapping[str, Any]:
        """Return the commands that plugins add, by name."""
        from driftform.cli.added import load_added

        return {name: command for name, command in load_added().commands.items() if name not in self.commands}

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the options before the name of a command."""
        with _one_line_for_each_error():
            return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        with _one_line_for_each_error():
            result = super().invoke(ctx)
            # A pipe that was closed early shows here, and not when the interpreter ends.
            sys.stdout.flush()
            return result


@contextmanager
def _one_line_for_each_error() -> Iterator[None]:
    try:
        yield
    except DriftformError as error:
        _print_errors(*(error.in_options or error.args))
        raise typer.Exit(error.exit_code) from None
    except UsageError as error:
        if type(error).__name__ == "NoArgsIsHelpError":
            raise
        message = error.format_message().replace("Input should be", "should be").rstrip(".")
        if re.match(r"No such option: -[\d.]", message):
            message += "; put '--' before a value that begins with a minus sign, after all options"
        _print_errors(f"{message}; see '{error.ctx.command_path} --help'" if error.ctx else message)
        raise typer.Exit(error.exit_code) from None
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        raise typer.Exit(130) from None
    except BrokenPipeError:
        # The reader has closed the pipe; the rest of the buffer must not fail once more at the end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(1) from None
    except OSError as error:
        named = error.filename is not None and error.strerror
        next_step = (
            "; free the disk, then try again" if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG) else ""
        )
        _print_errors((f"{os.fsdecode(error.filename)}: {error.strerror}" if named else str(error)) + next_step)
        raise typer.Exit(1) from None
    except (typer.Exit, typer.Abort):
        raise
    except (Exception, SystemExit) as error:
        from driftform.plugins.faults import trace_fault

        fault = trace_fault(error)
        if fault is None:
            raise
        _print_errors(fault)
        raise typer.Exit(1) from None


def _print_errors(*lines: object) -> None:
    for line in map(str, lines):
        print(f"error: {escape_controls(line)}", file=sys.stderr)


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    # Rich takes as long to import as everything else, and to it [robustness] in a help text is markup.
    rich_markup_mode=None,
    context_settings={"max_content_width": 110},
    help="Evolve the shape of a passive underwater agent so that the current alone carries it to where it is needed.",
)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"driftform {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    ctx: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and exit.", is_eager=True, callback=_print_version)
    ] = False,
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="Show no progress, only results, warnings and errors.")
    ] = False,
    verbose: Annotated[
        int, typer.Option("--verbose", "-v", count=True, show_default=False, help="Log each step; -vv in detail.")
    ] = 0,
) -> None:
    if quiet:
        ctx.with_resource(show_progress(lambda what, done, total: None))
    if verbose:
        import logging

        # A library has no handlers of its own. The stderr is that of the moment: a live display takes its place.
        logger, handler = logging.getLogger("driftform"), logging.StreamHandler()
        handler.emit = lambda log: print(f"{log.levelname.lower()}: {log.getMessage()}", file=sys.stderr)  # type: ignore
        logger.setLevel(logging.DEBUG if verbose > 1 else logging.INFO)
        logger.addHandler(handler)
        ctx.call_on_close(lambda: logger.removeHandler(handler))


design = partial(app.command, cls=Command, rich_help_panel=DESIGN)
files = partial(app.command, cls=Command, rich_help_panel=FILES)
design("evolve")(evolve.evolve)
design("resume")(resume.resume)
design("compare")(compare.compare)
design("watch")(watch.watch)
design("report")(report.report)
design("simulate")(simulate.simulate)
design("inspect")(inspect.inspect)
design("pick", context_settings=pick.NUMBERS)(pick.pick)
design("sample")(sample.sample)
files("export")(export.export)
files("export-flight")(export_flight.export_flight)
files("export-data")(export_data.export_data)
app.add_typer(plugins.app, name="plugins", rich_help_panel=FILES)
app.add_typer(scenarios.app, name="scenarios", rich_help_panel=DESIGN)
