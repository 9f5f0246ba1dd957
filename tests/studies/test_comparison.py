"""What searches with the same number of flights promise in disturbed water, as docs/results.md shows it.

``UPDATE_DOCS=1 pytest -m slow -s tests/studies/test_comparison.py`` writes the table and its figure anew; ``SEEDS=3`` takes fewer seeds.
"""

import json
import os
import shutil
from pathlib import Path

import pytest
import tomli_w

pytestmark = pytest.mark.slow

DOCS = Path(__file__).parents[2] / "docs"
SEEDS = 10

SEARCHES = {
    **{name: {"strategy": {"use": name}} for name in ("tuned", "direct", "evolution", "paper", "random")},
    "cma-es": {"grammar": {"use": "bspline"}, "strategy": {"use": "pymoo", "algorithm": "cmaes"}},
    "cma-me": {"grammar": {"use": "bspline"}, "strategy": {"use": "ribs", "emitter": "cma-me"}},
}


def tabulate(found):
    """Rows of Markdown: promises for weighed prints, and errors of undisturbed flights, means over targets."""
    lines = [
        f"| 500 flights, {len(found['tuned']['runs'])} seeds | 90 % miss of weighed prints, mm: median (quartiles) | minus `tuned` (95 %) | p | undisturbed error, % |",
        "|---|---|---|---|---|",
    ]
    for name, row in found.items():
        miss, fitness = row["miss"]["all targets"], row["fitness"]["all targets"]
        cells = [f"{miss['median']:.0f} ({miss['q1']:.0f}–{miss['q3']:.0f})", "", ""]
        if "difference" in miss:
            cells[1:] = f"{miss['difference']:.0f} ({miss['low']:.0f} to {miss['high']:.0f})", f"{miss['p']:.2g}"
        lines.append(f"| `{name}` | {' | '.join(cells)} | {100 - fitness['median']:.3f} |")
    return lines


def test_no_search_promises_less_than_tuned_bodies_do_with_as_many_flights(start, publish, tmp_path):
    for name, tables in SEARCHES.items():
        (tmp_path / f"{name}.toml").write_text(tomli_w.dumps({"base": "pipe-inspection", **tables}), encoding="utf-8")
    studies = [f"{name}.toml" for name in SEARCHES]
    budget = ("--seeds", os.environ.get("SEEDS", SEEDS), "--evaluations", 500, "--workers", 2)
    process = start("compare", *studies, *budget, "--out", "out", "--json", cwd=tmp_path)
    printed, told = process.communicate(timeout=4 * 3600)
    assert process.returncode == 0, told
    document = json.loads(printed)
    publish("comparison", tabulate(document["searches"]))
    if os.environ.get("UPDATE_DOCS") == "1":
        shutil.copy(tmp_path / document["figures"][0], DOCS / "images" / "comparison.svg")
    medians = {name: row["miss"]["all targets"]["median"] for name, row in document["searches"].items()}
    assert medians["tuned"] <= 1.05 * min(medians.values())
