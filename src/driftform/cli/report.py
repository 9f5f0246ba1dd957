"""``driftform report``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli.options import Json


def report(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory, finished or not.")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="The page; by default report.html in RUN.")
    ] = None,
    json: Json = False,
) -> None:
    """Write a run as one page: what was reached, pictures, and every best agent to turn, cut open and fly.

    The page is one file that needs no network. Pictures and best agents are those of the moment it is written.
    """
    from driftform.cli.output import print_json
    from driftform.report.contents import collect_contents
    from driftform.report.page import page_html
    from driftform.util.files import make_directory, write_text

    contents = collect_contents(run)
    path = out or run / "report.html"
    make_directory(path.parent)
    write_text(path, page_html(contents))
    if json:
        print_json({"report": str(path), "evaluations": contents.evaluations, "bytes": path.stat().st_size})
        return
    print(
        f"report: {path} ({path.stat().st_size / 1e6:.2f} MB, opens in any browser, also without a network)"
    )
