"""``driftform compare``."""

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING

import typer

from driftform.cli.options import FILE, declare

if TYPE_CHECKING:
    from driftform.search.comparison import Repeats


@declare(
    FILE,
    *(
        "study",
        "strategy",
        "grammar",
        "fitness",
        "hydrodynamics",
        "seeds",
        "seed",
        "evaluations",
        "robust",
        "workers",
        "scheduler",
        "simulator",
        "out",
        "style",
        "width_mm",
        "settings",
        "json",
    ),
)
def compare(given: SimpleNamespace) -> None:
    """Repeat searches over seeds with equal budgets, and compare what they find.

    What is named several times is compared: studies, strategies, grammars, fitnesses or hydrodynamic models; of several
    kinds, each combination. After an interruption the same command continues where it stopped. Each repeat is a run that
    the other commands open.
    """
    from driftform.cli import formats, output
    from driftform.figures.files import write_picture
    from driftform.figures.trend import trend_svg
    from driftform.search import comparison
    from driftform.search.comparison import ALL, MEASURES
    from driftform.util.files import check_directory, make_directory

    page, numbers = formats.parse_page(given.style, given.width_mm), range(given.seed, given.seed + given.seeds)
    use = {
        "strategy": given.strategy,
        "grammar": given.grammar,
        "fitness": given.fitness,
        "hydrodynamics": given.hydrodynamics,
    }
    more = [] if given.robust is None else [f"robustness.conditions={given.robust}"]
    searches = _load_searches(
        given.study,
        use,
        given.simulator,
        [*(given.settings or ()), *more],
        numbers,
        given.evaluations,
        check_directory(given.out),
    )
    search_repeats(
        list(searches.values()), given.scheduler, given.workers, f"the same driftform compare --out {given.out}"
    )
    outcomes = {name: comparison.read_outcome(repeats) for name, repeats in searches.items()}
    table = given.out / "comparison.csv"
    comparison.write_values(table, outcomes, numbers)
    subtitle = f"Best fitness so far (%) against flights: median and quartiles over {given.seeds} repeats"
    picture = trend_svg(comparison.draw_curves(outcomes), "Searches side by side", subtitle, page)
    figures = write_picture(make_directory(given.out / "figures") / "comparison.svg", picture, page)
    found = comparison.compare_outcomes(outcomes)
    if given.json:
        searched = {
            name: {**row, "failed": outcomes[name].failed, "runs": [str(path) for path in searches[name]]}
            for name, row in found.items()
        }
        output.print_json({"searches": searched, "table": str(table), "figures": [str(path) for path in figures]})
        return
    first, row = next(iter(found.items()))
    for measure in row:
        print(f"{MEASURES[measure][0]}, {MEASURES[measure][1]}, mean over targets, {given.seeds} repeats:")
        header = ("search", "median", "25 %", "75 %", f"minus {first}", "from", "to", "p")
        keys = ("median", "q1", "q3", "difference", "low", "high", "p")
        cells = ((name, *(_format(row[measure][ALL].get(key)) for key in keys)) for name, row in found.items())
        output.print_table(header, cells, right=range(1, len(header)))
    print(f"table:  {table}")
    print(f"figure: {', '.join(map(str, figures))}")
    print(f"runs:   {given.out}/runs/")


def _format(value: float | None) -> str:
    return "" if value is None else f"{value:.2g}" if abs(value) < 0.01 else f"{value:.3f}"


def _load_searches(
    studies: Sequence[str],
    use: Mapping[str, list[str] | None],
    simulator: str | None,
    settings: Sequence[str],
    seeds: Sequence[int],
    evaluations: int | None,
    out: Path,
) -> "dict[str, Repeats]":
    """Return the repeats of each search by its name: what of it differs from the others.

    Raises InputError if there is only one search, or two have the same name.
    """
    from driftform.errors import InputError
    from driftform.study import load_study

    searches: dict[str, Repeats] = {}
    for study, names in product(studies, product(*(chosen or [""] for chosen in use.values()))):
        parts = [Path(study).stem] if len(studies) > 1 else []
        parts += [name for name, chosen in zip(names, use.values(), strict=True) if len(chosen or ()) > 1]
        selected = {seam: name or None for seam, name in zip(use, names, strict=True)} | {"simulator": simulator}
        repeats = {}
        for seed in seeds:
            loaded = load_study(study, settings, use=selected, run={"seed": seed, "evaluations": evaluations})
            evaluations = loaded.evaluations
            repeats[out / "runs" / "-".join([*parts, str(seed)])] = loaded
        loaded.check_search()
        if (name := " ".join(parts)) in searches:
            raise InputError(f"two searches are called '{name}': name each once, and studies by different file names")
        searches[name] = repeats
    if len(searches) < 2:
        raise InputError("there is nothing to compare: name two or more, such as --strategy tuned --strategy random")
    return searches


def search_repeats(searches: "Sequence[Repeats]", scheduler: str | None, workers: int | None, command: str) -> None:
    """Search all repeats to their ends, with progress; where it is interrupted, say which ``command`` continues."""
    from functools import partial

    from driftform.cli.running import stop_at_signals
    from driftform.search.comparison import search_all
    from driftform.search.executors import open_executor
    from driftform.util.progress import count_progress

    open_place = partial(open_executor, scheduler=scheduler, workers=workers)
    try:
        with stop_at_signals(), count_progress("flights") as progress:
            problems = search_all(searches, open_place, progress)
    except KeyboardInterrupt as stop:
        typer.echo(f"stopped; this continues: {command}", err=True)
        raise typer.Exit(stop.args[0] if stop.args else 130) from None
    for problem in problems:
        typer.echo(f"warning: {problem}", err=True)
