"""``driftform report``."""

from pathlib import Path
from typing import Annotated

from driftform.cli.options import Json, RunArgument, Style, WidthMm, make_option


def report(
    run: RunArgument,
    out: Annotated[
        Path | None,
        make_option(
            "FILE",
            "File to write; by default RUN/report.html. With --style paper, directory for the figures; by default "
            "RUN/figures/paper.",
        ),
    ] = None,
    style: Style = "screen",
    width_mm: WidthMm = None,
    json: Json = False,
) -> None:
    """Write the report of a run, one HTML page: results, pictures, and the best agents and their flights in 3D.

    The page is one file that needs no network. It shows the state of the run when the command begins.

    With --style paper, writes the pictures as figures for publications instead.
    """
    from driftform.cli.formats import parse_page
    from driftform.cli.output import print_json
    from driftform.runs.run import StoredRun
    from driftform.search.report.page import write_figures, write_report

    page = parse_page(style, width_mm)
    if page.is_paper:
        figures = [str(path) for path in write_figures(StoredRun.open(run), out, page)]
        print_json({"figures": figures}) if json else print(*figures, sep="\n")
        return
    contents, path = write_report(StoredRun.open(run), out)
    size = path.stat().st_size
    if json:
        print_json({"report": str(path), "evaluations": contents.evaluations, "bytes": size})
        return
    print(f"report: {path} ({size / 1e6:.2f} MB, opens in any browser, also without a network)")
