"""``driftform studio``."""

from pathlib import Path
from types import SimpleNamespace as Given

from driftform.cli import options


@options.declare(Path(__file__).with_name("studio.toml"), "folder", "port", "browser", "json")
def studio(given: Given) -> None:
    """Open a local page to draw a pipe, search for agents, and take their files.

    The page is served on this machine only, under an address with a secret token, until Ctrl-C. Searches that it began
    continue. Everything that it makes is a run directory in FOLDER, which all other commands open.
    """
    from driftform.cli import output
    from driftform_studio.server import serve

    def announce(address: str) -> None:
        if given.json:
            output.print_json({"address": address, "folder": str(given.folder)})
        else:
            print(f"driftform studio: {address}\nCtrl-C ends the page; searches continue", flush=True)

    serve(given.folder, given.port, announce, given.browser)
