"""``driftform report``."""

from types import SimpleNamespace

from driftform.cli.options import FILE, declare


@declare(FILE, "run", "out", "style", "width_mm", "json")
def report(given: SimpleNamespace) -> None:
    """Write the report of a run, one HTML page: results, pictures, and the best agents and their flights in 3D.

    The page is one file that needs no network. It shows the state of the run when the command begins.

    With --style paper, writes the pictures as figures for publications instead.
    """
    from driftform.cli.formats import parse_page
    from driftform.cli.output import print_json
    from driftform.runs.run import StoredRun
    from driftform.search.report.page import write_figures, write_report

    page = parse_page(given.style, given.width_mm)
    if page.is_paper:
        figures = [str(path) for path in write_figures(StoredRun.open(given.run), given.out, page)]
        print_json({"figures": figures}) if given.json else print(*figures, sep="\n")
        return
    contents, path = write_report(StoredRun.open(given.run), given.out)
    size = path.stat().st_size
    if given.json:
        print_json({"report": str(path), "evaluations": contents.evaluations, "bytes": size})
        return
    print(f"report: {path} ({size / 1e6:.2f} MB, opens in any browser, also without a network)")
