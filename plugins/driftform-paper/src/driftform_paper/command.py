"""``driftform reproduce``."""

from pathlib import Path
from types import SimpleNamespace as Given

from driftform.cli import options


@options.declare(
    Path(__file__).with_name("reproduce.toml"),
    *("repeats", "seed", "workers", "scheduler", "simulator", "out", "style", "width_mm", "settings", "json"),
)
def reproduce(given: Given) -> None:
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

    page, out = formats.parse_page(given.style, given.width_mm), given.out
    started = time.perf_counter()
    seeds = range(given.seed, given.seed + given.repeats)
    studies = {
        (s, n): load_study(
            "paper",
            given.settings or (),
            use={"strategy": s, "simulator": given.simulator},
            run={"seed": n, "evaluations": None},
        )
        for s in STRATEGIES
        for n in seeds
    }
    first = next(iter(studies.values()))
    files.make_directory(out)
    runs = {key: out / "runs" / f"{key[0]}-{key[1]}" for key in studies}
    searches = [{runs[key]: study for key, study in studies.items() if key[0] == s} for s in STRATEGIES]
    search_repeats(searches, given.scheduler, given.workers, f"driftform reproduce --out {out}")
    found = {s: read_results([(n, runs[s, n]) for n in seeds]) for s in STRATEGIES}
    again = resimulate(first, found["paper"])
    figures = write_figures(out / "figures", first, found, again, page)
    seconds = time.perf_counter() - started
    markdown = results_markdown(first.scenario, found, again)
    files.write_text(out / "results.md", markdown)
    if given.json:
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
