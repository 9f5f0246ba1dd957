"""How much of the pipe do the strategies reach, and how close does a run come to points that were no targets?

``FLIGHTS=2000 pytest -m slow -s tests/studies/test_reach.py`` takes fewer than the page tells of.
"""

import os
from dataclasses import dataclass

import numpy as np
import pytest

from driftform.motion.path.approach import closest_approach
from driftform.runs.coverage import CoverageMap, PipeGrid
from driftform.runs.store import Store
from driftform.search.local import LocalProcesses
from driftform.search.loop import run_search
from driftform.study import load_study

pytestmark = pytest.mark.slow

FLIGHTS = 20_000
SHORTER = 4
"""A second run of ribs, and the strategies other than it and random search, get this many times fewer flights."""

MILESTONES = (500, 1000, 2000, 5000, 20_000)
"""Numbers of flights after which the cells are counted."""

POINTS = 100
NEAR = 0.05
"""m."""


@dataclass(frozen=True, eq=False)
class Lit:
    """What one run reaches: cells at each milestone, and how close it comes to each of the points (m)."""

    strategy: str
    seed: int
    milestones: dict[int, int]
    reach: CoverageMap
    distances: np.ndarray

    @property
    def near(self):
        return int(np.count_nonzero(self.distances <= NEAR))


def random_points(scenario):
    """Points of the pipe's section y = 0, each as likely as any: no flight from the axis leaves that plane."""
    [pipe] = scenario.pipe.segments
    rng = np.random.default_rng(2026)
    x = rng.uniform(pipe.start[0], pipe.end[0], POINTS)
    z = rng.uniform(-pipe.radius, pipe.radius, POINTS)
    return np.column_stack([x, np.zeros(POINTS), z])


def lit(folder, strategy, seed, flights):
    study = load_study(
        "paper", use={"simulator": "native", "strategy": strategy}, run={"seed": seed, "evaluations": flights}
    )
    executor = LocalProcesses(study.document, 2)
    points = random_points(study.scenario)
    reach, milestones = CoverageMap(PipeGrid.of_scenario(study.scenario)), {}
    distances = np.full(POINTS, np.inf)
    with Store.create(folder / f"{strategy}-{seed}.db", dict(study.document)) as store:
        try:
            run_search(study, store, executor)
        finally:
            executor.close()
        for index, trajectory in store.read_trajectories():
            for milestone in MILESTONES:
                if index >= milestone and milestone not in milestones:
                    milestones[milestone] = int(np.count_nonzero(reach.reached))
            reach.add(index, trajectory)
            distances = np.minimum(distances, closest_approach(trajectory, points)[0])
    milestones[flights] = int(np.count_nonzero(reach.reached))
    return Lit(strategy, seed, milestones, reach, distances)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lit")
    flights = int(os.environ.get("FLIGHTS", FLIGHTS))
    # The searches of tuned bodies need a builder that can tune.
    others = ("evolution", "paper")
    whole = [lit(folder, name, 1, flights) for name in ("ribs", "random")]
    return whole + [lit(folder, name, 2 if name == "ribs" else 1, flights // SHORTER) for name in ("ribs", *others)]


def missed_text(points, missed):
    return ", ".join(f"({x:.2f}, {z:.2f})" for x, _, z in points[missed]) or "none"


def test_ribs_reaches_what_any_strategy_ever_reached_and_points_that_were_no_targets(runs, publish):
    cells = runs[0].reach.cells
    ever = np.any([run.reach.reached for run in runs], axis=0)
    everything = int(np.count_nonzero(ever))
    scenario = load_study("paper", run={"seed": 0}).scenario
    points = random_points(scenario)
    counts = [milestone for milestone in MILESTONES if any(milestone in run.milestones for run in runs)]
    lines = [
        f"Any of these runs crosses {everything} of {cells.cell_count} cells; shares are of those {everything}.",
        "",
        "| strategy | seed | " + " | ".join(f"{count} flights" for count in counts) + " | within 5 cm | within 1 cm |",
        "|---|---|" + "---|" * (len(counts) + 2),
    ]
    for run in runs:
        shares = [
            f"{100 * run.milestones[count] / everything:.1f} %" if count in run.milestones else "" for count in counts
        ]
        tight = int(np.count_nonzero(run.distances <= 0.01))
        lines.append(
            f"| {run.strategy} | {run.seed} | "
            + " | ".join(shares)
            + f" | {run.near} of {POINTS} | {tight} of {POINTS} |"
        )
    dark = cells.centres()[~ever]
    lines += [
        "",
        f"No run crosses the other {len(dark)} cells: their middles lie up to {dark[:, 0].max():.2f} m from the inlet."
        if len(dark)
        else "Every cell is crossed.",
        f"Points farther than 5 cm from every flight of `ribs` (seed 1), as (x, z): "
        f"{missed_text(points, runs[0].distances > NEAR)}.",
    ]
    publish("reach", lines)
    for run in runs:
        if run.strategy == "ribs":
            assert np.count_nonzero(run.reach.reached) >= 0.95 * everything
            assert run.near >= 90
