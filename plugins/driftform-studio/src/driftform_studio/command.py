"""``driftform studio``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli import options


def studio(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Folder of the runs; created if it does not exist.")
    ] = Path("runs"),
    port: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            max=65535,
            help="Port on 127.0.0.1; by default the last port of FOLDER, or any free port.",
        ),
    ] = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")] = True,
    json: options.Json = False,
) -> None:
    """Open a local page to draw a pipe, search for agents, and take their files.

    The page is served on this machine only, under an address with a secret token, until Ctrl-C. Searches that it began
    continue. Everything that it makes is a run directory in FOLDER, which all other commands open.
    """
    from driftform.cli import output
    from driftform_studio.server import serve

    def announce(address: str) -> None:
        if json:
            output.print_json({"address": address, "folder": str(folder)})
        else:
            print(f"driftform studio: {address}\nCtrl-C ends the page; searches continue", flush=True)

    serve(folder, port, announce, browser)
