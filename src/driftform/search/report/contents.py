"""A run -> the contents of its page: the best agents, their flights, and the pictures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from driftform.errors import DriftformError, WorkFailedError, describe_error
from driftform.figures.dependence import dependence_svg
from driftform.figures.reach import reach_svg
from driftform.figures.result import result_svg
from driftform.figures.strip import Strip, strip_svg
from driftform.figures.style import SCREEN, Page
from driftform.figures.trend import Curve, choose_points, trend_svg
from driftform.interfaces import Flown, ReportJob
from driftform.plugins.discovery import find_modules
from driftform.runs.found import FOUND, read_found
from driftform.runs.run import StoredRun
from driftform.runs.status import Missed
from driftform.runs.store import Store
from driftform.runs.table_files import evaluation_columns
from driftform.search.results import BestFlight, draw_overview, map_run, read_best
from driftform.study import Study
from driftform.water import Scenario


@dataclass(frozen=True, eq=False)
class Contents:
    """Contents of the page of a run.

    ``commonest_failure`` is the first of the commonest kind of failure, and how many there are, ``missed`` says which
    constraints are missed. ``seconds`` is the total time of all evaluations on the machines that made them, ``units`` are
    those of measures. ``causes`` has a picture for each target of what the miss depends on, if enough flights succeeded. ``added`` are the sections of plugins by their headings, and ``problems`` has a line for each plugin
    that failed to make its own.
    """

    name: str
    study: Study
    evaluations: int
    failed: int
    commonest_failure: tuple[str, int]
    missed: str
    seconds: float
    entries: Sequence[BestFlight]
    units: Mapping[str, str]
    figures: Mapping[str, str]
    causes: Mapping[str, str]
    added: Mapping[str, str]
    problems: Sequence[str]

    @property
    def agents(self) -> list[list[BestFlight]]:
        """The entries in groups of those that have the same agent."""
        groups: dict[int, list[BestFlight]] = {}
        for entry in self.entries:
            groups.setdefault(entry.index, []).append(entry)
        return list(groups.values())


def collect_contents(run: StoredRun, page: Page = SCREEN) -> Contents:
    """Read a run, finished or not, and draw its pictures for a page.

    Raises InputError if the run is damaged. Raises WorkFailedError if no evaluation succeeded yet.
    """
    study, scenario = run.study, run.study.scenario
    targets = scenario.target_names
    strategy = str(study.document.get("strategy", {}).get("use", "search"))
    columns = evaluation_columns(targets, study.make_plugin("fitness").measures)
    units = {"fitness": "%"} | {column.name: column.unit for column in columns}
    with run.read() as store:
        if store.count_failed() == store.count():
            raise WorkFailedError(f"{run.path}: has no successful evaluation to report")
        entries, missed = read_best(run, store), Missed()
        for brief in store.read_summaries(()):
            missed.add(brief.violations)
        promises = {one.target: one.misses for one in entries if one.misses is not None}
        figures = {
            "Flights and bodies": draw_overview(study, entries, page),
            "Search": _draw_search(store, targets, strategy, page),
            "Reach": reach_svg(map_run(study, store), scenario, study.title, page),
        }
        strips = [
            Strip(e.target, e.distance, misses.distances[:, 0], float(misses.promised[0]))
            for e in entries
            if (misses := promises.get(e.target)) is not None
        ]
        if strips:
            count = study.scenario.robustness.checks
            subtitle = f"{count} flights of each best agent under disturbed conditions that the choice never saw."
            figures["Robustness"] = strip_svg(strips, "Misses under disturbed conditions", subtitle, page)
        for name, kept in read_found(run.path / FOUND).items():
            if kept.axes:
                title = f"{name.replace('_', ' ').capitalize()} of {strategy}"
                figures[title] = result_svg(kept, title, units, page)
        return Contents(
            run.name,
            study,
            store.count(),
            store.count_failed(),
            store.find_commonest_failure(),
            str(missed),
            store.total_seconds(),
            entries,
            units,
            figures,
            {
                target: dependence_svg(effects, f"What the miss of {target} depends on", page)
                for target, misses in promises.items()
                if (effects := misses.list_effects(0)) is not None
            },
            *_ask_plugins(run.name, scenario, entries),
        )


def _ask_plugins(name: str, scenario: Scenario, entries: Sequence[BestFlight]) -> tuple[dict[str, str], list[str]]:
    """Return the sections of all plugins by their headings, and one line for each plugin that failed."""
    best = {e.target: Flown(e.stored.name, e.agent, e.trajectory, e.stored.result["fitness"]) for e in entries}
    job, added, problems = ReportJob(name, scenario, best), dict[str, str](), list[str]()
    for plugin in find_modules():
        hook = plugin.find_hook("driftform_report")
        try:
            sections = dict({} if hook is None else hook(job))
            if not all(isinstance(text, str) for row in sections.items() for text in row):
                raise TypeError("expected texts by their headings")
            added |= sections
        except (Exception, SystemExit) as error:
            reason = describe_error(error, with_place=not isinstance(error, DriftformError))
            problems.append(f"driftform_report of {plugin.distribution} failed: {reason}")
    return added, problems


def _draw_search(store: Store, targets: Sequence[str], strategy: str, page: Page) -> str:
    """Return the picture of the best fitness so far of a run for each target, over all of its flights."""
    fitness = np.array([brief.fitness for brief in store.read_summaries(targets)]).reshape(-1, len(targets))
    at = choose_points(len(fitness))
    best = np.maximum.accumulate(fitness, axis=0)[at - 1].T
    panels = {target: [Curve(strategy, at, row)] for target, row in zip(targets, best, strict=True)}
    return trend_svg(
        panels, "Best fitness so far", "Best fitness so far (%) against flights for the target: one run", page
    )
