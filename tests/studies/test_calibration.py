"""Do the intervals of a calibration hold the truth, and do calibrated agents come nearer to their targets?

``UPDATE_DOCS=1 pytest -m slow -s tests/studies/test_calibration.py`` writes the tables of docs/calibration.md. Each trial
is kept in a file as soon as it is done, ``$TRIALS`` or ``.cache/calibration-trials.jsonl``: an interrupted study goes on
where it was. Remove the file after a change of the model.
"""

import json
import os
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from driftform.calibration.fit import fit_factors
from driftform.scenario.calibration import NAMES
from driftform.study import load_study
from driftform.testing.films import draw_world, film_flight, place_drop

pytestmark = pytest.mark.slow

TRIALS = int(os.environ.get("COUNT", "100"))
PITCHES_DEG = (-45.0, 0.0, 45.0)
SEED = 23
ENOUGH = 30
"""Number of trials that know a factor from which a share of them says something."""

KEPT = Path(os.environ.get("TRIALS", Path(__file__).parents[2] / ".cache" / "calibration-trials.jsonl"))


def run_trial(number: int) -> dict[str, Any]:
    """Film a random agent in a random world, fit the factors, and return both."""
    rng = np.random.default_rng((SEED, number))
    pipeline = load_study("tank", run={"seed": 0}).make_pipeline()
    morphology = pipeline.express(pipeline.grammar.random(rng))
    benches = [place_drop(pipeline, morphology, pitch) for pitch in PITCHES_DEG]
    world = draw_world(benches[0], rng)
    films = [film_flight(bench, world, rng) for bench in benches]
    start = time.process_time()
    fit = fit_factors(films)
    return {
        "trial": number,
        "seconds": time.process_time() - start,
        "residual": fit.residual,
        "world": asdict(world),
        "found": {n: [e.value, e.low, e.high, e.known, e.reason] for n, e in fit.estimates.items()},
    }


@pytest.fixture(scope="module")
def trials() -> list[dict[str, Any]]:
    KEPT.parent.mkdir(parents=True, exist_ok=True)
    done = {}
    if KEPT.is_file():
        done = {row["trial"]: row for row in map(json.loads, KEPT.read_text(encoding="utf-8").splitlines())}
    for number in range(TRIALS):
        if number not in done:
            done[number] = run_trial(number)
            with KEPT.open("a", encoding="utf-8") as file:
                file.write(json.dumps(done[number]) + "\n")
    return [done[number] for number in range(TRIALS)]


def test_intervals_hold_the_truth(
    trials: list[dict[str, Any]], publish: Callable[[str, Sequence[str]], None]
) -> None:
    lines = [
        "| factor | known in | interval holds the truth | half of the interval, median | else, mostly |",
        "|---|---|---|---|---|",
    ]
    shares = {}
    for name in NAMES:
        known = [row for row in trials if row["found"][name][3]]
        held = [r["found"][name][1] <= r["world"][name] <= r["found"][name][2] for r in known]
        half = [(r["found"][name][2] - r["found"][name][1]) / 2 / r["found"][name][0] for r in known]
        reasons = Counter(
            reason.split(" from ")[0].split(" possible")[0]
            for reason in (row["found"][name][4] for row in trials)
            if reason
        )
        why = reasons.most_common(1)[0][0] if reasons else ""
        if held:
            shares[name] = (float(np.mean(held)), len(held))
            cell = f"{100 * np.mean(held):.0f} % | {100 * np.median(half):.1f} %"
        else:
            cell = "| "
        lines.append(f"| {name.replace('_', ' ')} | {len(known)} of {len(trials)} | {cell} | {why} |")
    every = sum(share * count for share, count in shares.values()) / sum(c for _, c in shares.values())
    seconds = [row["seconds"] for row in trials]
    lines += [
        f"| all | | {100 * every:.0f} % | | |",
        "",
        f"A fit of three films takes {np.median(seconds):.1f} s in the median, {max(seconds):.0f} s at most.",
    ]
    publish("coverage", lines)
    assert 0.85 <= every <= 0.95
    for name, (share, count) in shares.items():
        if count >= ENOUGH:
            assert 0.85 <= share <= 0.95, f"{name}: {share:.2f} of {count}"
    assert max(seconds) < 20
