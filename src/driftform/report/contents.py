"""A run -> the contents of its page: the best agents, their flights, and the pictures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from driftform.errors import WorkFailedError
from driftform.figures.gallery import GalleryEntry
from driftform.figures.overview import overview_svg
from driftform.figures.projection import simplify_polyline
from driftform.figures.reach import reach_svg
from driftform.figures.section import section_svg
from driftform.figures.strip import Strip, strip_svg
from driftform.figures.style import SERIES
from driftform.figures.trend import Trend, trend_svg
from driftform.runs.agent_file import StoredAgent
from driftform.runs.finalists import find_best_agent, find_winner
from driftform.runs.run import Run
from driftform.runs.store import Store
from driftform.scenario import Scenario
from driftform.study import Study
from driftform.trajectory.approach import closest_approach
from driftform.trajectory.coverage import PipeGrid, map_coverage
from driftform.trajectory.interpolation import interpolate_positions
from driftform.types import Agent, FloatArray, Trajectory
from driftform.util.progress import track_progress

MAX_SAMPLES = 240
"""Greatest number of samples of a flight on a page."""

CONTOUR_TOLERANCE = 5e-5
"""Tolerance to which the contours of a page are simplified, m."""

TREND_POINTS = 60
"""Greatest number of points of a trend."""


@dataclass(frozen=True, eq=False)
class Entry:
    """The best agent for one target: the ``index`` of its evaluation, and its closest approach (``distance``, m, at ``t``, s)."""

    target: str
    index: int
    fitness: float
    distance: float
    t: float
    stored: StoredAgent
    agent: Agent
    trajectory: Trajectory

    @property
    def error_percent(self) -> float:
        """Error, % of the farthest distance in the pipe."""
        return 100 - self.fitness


@dataclass(frozen=True, eq=False)
class Contents:
    """Contents of the page of a run.

    ``seconds`` is the total time of all evaluations on the machines that made them.
    """

    name: str
    study: Study
    evaluations: int
    failed: int
    seconds: float
    entries: tuple[Entry, ...]
    figures: Mapping[str, str]
    sections: Sequence[str]

    @property
    def scenario(self) -> Scenario:
        """The scenario of the study."""
        return self.study.scenario


def collect_contents(run: Run) -> Contents:
    """Read a run, finished or not.

    Raises
    ------
    InputError
        if the run is damaged.
    WorkFailedError
        if no evaluation succeeded yet.
    """
    study = run.study
    with run.read() as store:
        targets = study.scenario.target_names
        pipeline = study.make_pipeline()
        entries = []
        for target in targets:
            stored = find_best_agent(study, store, target)
            if stored is None:
                raise WorkFailedError(f"{run.path}: has no successful evaluation to report")
            index = stored.result["evaluation"]
            flight = store.read_record(index, targets).evaluation.trajectory
            assert flight is not None
            point = np.array([study.scenario.targets[target]])
            distance, t = closest_approach(flight, point)
            agent = pipeline.make_agent(stored.genome)
            entries.append(
                Entry(
                    target,
                    index,
                    stored.result["fitness"],
                    float(distance[0]),
                    float(t[0]),
                    stored,
                    agent,
                    flight,
                )
            )
        title = str(study.document.get("title", ""))
        flights = [GalleryEntry(e.target, e.agent, e.trajectory, e.error_percent) for e in entries]
        seen = track_progress(store.read_trajectories(), store.count_sound(), "flights")
        figures = {
            "Flights and bodies": overview_svg(flights, study.scenario, title),
            "Search": trend_svg(_read_trends(store, targets), "Best fitness so far", _strategy_name(study)),
            "Reach": reach_svg(
                map_coverage(seen, PipeGrid.of_scenario(study.scenario)), study.scenario, title
            ),
        }
        strips = [
            Strip(e.target, e.error_percent, 100 - won.flights)
            for e in entries
            if (won := find_winner(study, store, e.target)) is not None
        ]
        if strips:
            subtitle = (
                f"{len(strips[0].errors)} flights of each best agent under randomly disturbed conditions"
            )
            figures["Robustness"] = strip_svg(strips, "Under disturbed conditions", subtitle)
        return Contents(
            run.name,
            study,
            store.count(),
            store.count_failed(),
            store.total_seconds(),
            tuple(entries),
            figures,
            [section_svg(e.agent, e.target, study.scenario) for e in entries],
        )


def _strategy_name(study: Study) -> str:
    return str(study.document.get("strategy", {}).get("use", "search"))


def _read_trends(store: Store, targets: Sequence[str]) -> list[Trend]:
    """Return the best fitness so far of a run for each target, over all of its flights."""
    fitness = np.array([brief.fitness for brief in store.read_summaries(targets)]).reshape(-1, len(targets))
    best = np.maximum.accumulate(fitness, axis=0)
    at = np.unique(np.linspace(1, len(best), min(TREND_POINTS, len(best))).astype(int))
    no_baseline = np.zeros((0, len(at)))
    return [
        Trend(target, at.astype(np.float64), best[None, at - 1, number], no_baseline)
        for number, target in enumerate(targets)
    ]


def viewer_data(contents: Contents) -> dict[str, Any]:
    """Return the data of the page's viewer: agents, flights, pipe and targets; SI units, rounded to what is visible."""
    scenario = contents.scenario
    rows = scenario.pipe.array()
    ends = np.vstack([rows[:, :3], rows[:, 3:6]])
    low, high = ends.min(axis=0), ends.max(axis=0)
    radius = float(rows[:, 6].max())
    length = float(np.linalg.norm(high - low))
    longest = max(entry.agent.body.length for entry in contents.entries)
    return {
        "agents": [_viewer_agent(entry, SERIES[i % len(SERIES)]) for i, entry in enumerate(contents.entries)],
        "pipe": [{"start": _round(r[:3]), "end": _round(r[3:6]), "radius": float(r[6])} for r in rows],
        "targets": [{"name": name, "position": list(point)} for name, point in scenario.targets.items()],
        "water": scenario.fluid.water_level,
        "centre": _round((low + high) / 2),
        "extent": [_round(low[:2] - radius), _round(high[:2] + radius)],
        "length": length,
        "size": radius,
        # Agents are many times smaller than their pipe, so the longest is drawn as long as its radius.
        "magnification": max(1.0, round(radius / longest, 1)),
    }


def _viewer_agent(entry: Entry, colour: str) -> dict[str, Any]:
    body, flight = entry.agent.body, entry.trajectory
    # Evenly in time, and at the closest approach.
    t = np.unique(np.append(np.linspace(flight.t[0], flight.t[-1], MAX_SAMPLES - 1), entry.t))
    nearest = np.clip(np.searchsorted(flight.t, t), 0, len(flight.t) - 1)
    return {
        "target": entry.target,
        "colour": colour,
        "outer": _round(simplify_polyline(body.outer, CONTOUR_TOLERANCE), 6),
        "cavity": _round(simplify_polyline(body.cavity, CONTOUR_TOLERANCE), 6) if len(body.cavity) else [],
        "joints": _round(body.joints, 6),
        "core": body.core.radius,
        "closest": round(entry.t, 4),
        "flight": {
            "t": _round(t, 4),
            "position": _round(interpolate_positions(flight, t), 4),
            "quaternion": _round(flight.quaternion[nearest], 4),
        },
    }


def _round(values: FloatArray, digits: int = 6) -> Any:
    return np.round(values, digits).tolist()
