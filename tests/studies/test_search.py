"""What the searches find in the paper's pipe, over ten seeds, as docs/results.md tells of it.

``UPDATE_DOCS=1 pytest -m slow -s tests/studies/test_search.py`` writes the tables anew; ``SEEDS=2`` takes fewer seeds.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from driftform.execution import Executor, LocalProcesses
from driftform.runs.search import run_search
from driftform.runs.store import Store
from driftform.study import Study, load_study
from driftform.types import FloatArray

pytestmark = pytest.mark.slow

SEEDS = 10
SEARCHES = (("paper", 500), ("random", 500), ("evolution", 500), ("random", 2000), ("evolution", 2000))
"""Strategies and flights, which ten targets share."""


def study_of(strategy: str, flights: int, seed: int) -> Study:
    use = {"strategy": strategy, "simulator": "native"}
    return load_study("paper", use=use, run={"seed": seed, "evaluations": flights})


@pytest.fixture(scope="module")
def executor() -> Iterator[Executor]:
    with closing(LocalProcesses(study_of("random", 1, 1).document, 2)) as executor:
        yield executor


@pytest.fixture(scope="module")
def errors(executor: Executor, tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, int], FloatArray]:
    """Error (%) of the best flight for each target, (seeds, targets), of every search."""
    folder = tmp_path_factory.mktemp("searches")
    return {search: np.array(list(_runs(*search, executor, folder))) for search in SEARCHES}


def _runs(strategy: str, flights: int, executor: Executor, folder: Path) -> Iterator[FloatArray]:
    for seed in range(1, int(os.environ.get("SEEDS", SEEDS)) + 1):
        study = study_of(strategy, flights, seed)
        with Store.create(folder / f"{strategy}-{flights}-{seed}.db", dict(study.document)) as store:
            run_search(study, store, executor)
            best = [store.find_best(target) for target in study.scenario.target_names]
        found = np.array([100.0 - fitness for _, fitness in filter(None, best)])
        print(f"{strategy}, {flights} flights, seed {seed}: worst target {found.max():.2f} %", flush=True)
        yield found


def test_the_searches_are_told(
    errors: dict[tuple[str, int], FloatArray], publish: Callable[[str, Sequence[str]], None]
) -> None:
    names = study_of("random", 1, 1).scenario.target_names
    heads = [f"{strategy}, {flights}" for strategy, flights in SEARCHES]
    lines = [
        f"| target | {' | '.join(f'{head}: mean (std, worst)' for head in heads)} |",
        "|---" * (1 + len(heads)) + "|",
    ]
    for number, name in enumerate(names):
        cells = [
            f"{e[:, number].mean():.2f} ({e[:, number].std():.2f}, {e[:, number].max():.2f})"
            for e in errors.values()
        ]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    publish("searches", lines)
    lines = [
        "| strategy | flights | mean of all targets | worst target: mean over seeds | at most |",
        "|---|---|---|---|---|",
    ]
    for (strategy, flights), e in errors.items():
        worst = e.max(axis=1)
        lines.append(
            f"| `{strategy}` | {flights} | {e.mean():.3f} | {worst.mean():.2f} | {worst.max():.2f} |"
        )
    publish("worst targets", lines)


def test_evolution_reaches_every_target_with_the_papers_flights(
    errors: dict[tuple[str, int], FloatArray],
) -> None:
    worst = errors["evolution", 500].max(axis=1)
    assert worst.mean() <= 0.5
    assert worst.max() <= 1.0


def test_evolution_goes_on_getting_better(errors: dict[tuple[str, int], FloatArray]) -> None:
    assert errors["evolution", 2000].max(axis=1).mean() <= 0.2


@pytest.mark.parametrize("flights", [500, 2000])
def test_evolution_beats_random_search_for_every_target(
    errors: dict[tuple[str, int], FloatArray], flights: int
) -> None:
    assert (errors["evolution", flights].mean(axis=0) < errors["random", flights].mean(axis=0)).all()
