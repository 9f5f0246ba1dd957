"""The commands, put together; errors of the user become one line and an exit code."""

import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from driftform import __version__
from driftform.cli import evolve, export, inspect, plugins, resume, sample, scenarios, simulate
from driftform.errors import DriftformError


class Commands(TyperGroup):
    """Turns what went wrong with the user's input or work into a line on stderr and an exit code.

    0 done, 1 the work failed, 2 the input is wrong, 130 interrupted.
    """

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        try:
            return super().invoke(ctx)
        except DriftformError as error:
            for line in str(error).splitlines():
                print(f"error: {line}", file=sys.stderr)
            raise typer.Exit(error.exit_code) from None
        except KeyboardInterrupt:
            print("interrupted", file=sys.stderr)
            raise typer.Exit(130) from None
        except BrokenPipeError:
            # Whoever read our output has seen enough; closing stderr keeps the interpreter from complaining.
            sys.stderr.close()
            raise typer.Exit(1) from None


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Evolve the shape of a passive underwater agent so that the current alone carries it to where it is needed.",
)


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and end.", is_eager=True)
    ] = False,
) -> None:
    if version:
        print(f"driftform {__version__}")
        raise typer.Exit


app.command("evolve")(evolve.evolve)
app.command("resume")(resume.resume)
app.command("sample")(sample.sample)
app.command("simulate")(simulate.simulate)
app.command("inspect")(inspect.inspect)
app.command("export")(export.export)
app.add_typer(plugins.app, name="plugins")
app.add_typer(scenarios.app, name="scenarios")
