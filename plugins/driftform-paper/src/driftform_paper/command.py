"""``driftform reproduce``."""

from pathlib import Path
from typing import Annotated

import typer

from driftform.cli import options


def reproduce(
    repeats: Annotated[
        int, typer.Option(metavar="N", min=1, max=1000, help="Repeats of each search, each with its own seed.")
    ] = 10,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed of the first repeat.")] = 1,
    workers: options.Workers = None,
    scheduler: options.Scheduler = None,
    simulator: options.Simulator = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Directory for runs, tables and figures.")] = Path(
        "reproduction"
    ),
    style: options.Style = "screen",
    width_mm: options.WidthMm = None,
    settings: options.Settings = None,
    json: options.Json = False,
) -> None:
    """Repeat the paper's experiment and random search, and compare the paper's figures with ours.

    Flies 50 agents for each of ten targets and each repeat, then flies the best agents again. After an interruption
    the same command continues where it stopped; the same seed gives the same tables.
    """
    import time

    from driftform import load_study
    from driftform.cli import formats, output, search_repeats
    from driftform.util import files
    from driftform_paper.repeats import STRATEGIES, read_results
    from driftform_paper.report import resimulate, results_document, results_markdown, write_figures

    page = formats.parse_page(style, width_mm)
    started = time.perf_counter()
    seeds = range(seed, seed + repeats)
    studies = {
        (s, n): load_study(
            "paper", settings or (), use={"strategy": s, "simulator": simulator}, run={"seed": n, "evaluations": None}
        )
        for s in STRATEGIES
        for n in seeds
    }
    first = next(iter(studies.values()))
    files.make_directory(out)
    runs = {key: out / "runs" / f"{key[0]}-{key[1]}" for key in studies}
    searches = [{runs[key]: study for key, study in studies.items() if key[0] == s} for s in STRATEGIES]
    search_repeats(searches, scheduler, workers, f"driftform reproduce --out {out}")
    found = {s: read_results([(n, runs[s, n]) for n in seeds]) for s in STRATEGIES}
    again = resimulate(first, found["paper"])
    figures = write_figures(out / "figures", first, found, again, page)
    seconds = time.perf_counter() - started
    markdown = results_markdown(first.scenario, found, again)
    files.write_text(out / "results.md", markdown)
    if json:
        output.print_json(
            {
                **results_document(first.scenario, found, again),
                "seconds": seconds,
                "results": str(out / "results.md"),
                "figures": [str(path) for path in figures],
                "runs": [str(path) for path in runs.values()],
            }
        )
        return
    print(markdown)
    print(f"{sum(study.evaluations for study in studies.values())} flights, {seconds:.0f} s")
    print(f"tables:  {out}/results.md")
    print(f"figures: {out}/figures/ ({', '.join(path.name for path in figures)})")
    print(f"runs:    {out}/runs/ ({len(runs)}: each opens with the other commands)")
