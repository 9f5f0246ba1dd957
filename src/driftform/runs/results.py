"""What a run leaves behind: the best agents with their files, and pictures of all flights."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from driftform.errors import DriftformError, InputError, WorkFailedError
from driftform.execution import Executor
from driftform.faults import report_faults, require_files
from driftform.interfaces import ExportJob
from driftform.runs.agent_file import StoredAgent, agent_document, write_agent
from driftform.runs.directory import DATABASE
from driftform.runs.finalists import find_best_agent
from driftform.runs.store import Store
from driftform.runs.wording import describe_worst
from driftform.study import Study
from driftform.types import Agent, Trajectory
from driftform.util.files import remove_parts, write_text
from driftform.util.progress import track_progress

# Drawing needs the compiled kernels, which take half a second to load. They are imported only inside the functions that
# draw: worker processes, which have loaded them already, call these, and the coordinator starts its workers earlier.

T = TypeVar("T")


@dataclass(frozen=True)
class Best:
    """The best of a run for one target.

    Attributes
    ----------
    target
        its name.
    index
        of the evaluation.
    fitness
        for that target, %.
    distance
        of its closest approach, m.
    agent
        path of its ``agent.json``.
    files
        paths of whatever else was written.
    problems
        what could not be written, one line for each.
    robust
        what it came to under disturbed conditions, empty where there were none.
    """

    target: str
    index: int
    fitness: float
    distance: float
    agent: Path
    files: tuple[Path, ...] = ()
    problems: tuple[str, ...] = ()
    robust: Mapping[str, Any] = field(default_factory=dict)

    @property
    def error_percent(self) -> float:
        """Distance of closest approach, in percent of the farthest distance in the pipe (eq. 25)."""
        return 100 - self.fitness


def write_results(directory: Path, study: Study, executor: Executor) -> list[Best]:
    """Write the best agent of each target, the overview and the map of a run's directory; return the best agents.

    The executor writes them at the same time, each file completely or not at all.

    Raises
    ------
    WorkFailedError
        where not one evaluation succeeded; the message gives the reason of the first.
    InputError
        where a stored evaluation is damaged.
    """
    write_targets = [partial(_write_target, target=target) for target in study.scenario.targets]
    # What takes longest first.
    pieces: list[Callable[[Path, Study, Store], Any]] = [_write_overview, _write_reach, *write_targets]
    tasks = [partial(_call_with_store, write, directory, study) for write in pieces]
    try:
        _, _, *results = executor.call(tasks)
    except BaseException:
        for folder in ("best", "figures"):
            remove_parts(directory / folder)
        raise
    return results


def _call_with_store(write: Callable[[Path, Study, Store], T], directory: Path, study: Study) -> T:
    with Store.open(directory / DATABASE, read_only=True, check=False) as store:
        return write(directory, study, store)


def _read_best(directory: Path, study: Study, store: Store, target: str) -> tuple[StoredAgent, Trajectory]:
    stored = find_best_agent(study, store, target)
    targets = study.scenario.target_names
    if stored is None:
        reason, count = store.find_commonest_failure()
        raise WorkFailedError(f"all {store.count()} evaluations failed, {count} of them like this: {reason}")
    index = stored.result["evaluation"]
    flight = store.read_record(index, targets).evaluation.trajectory
    if flight is None:
        raise InputError(f"{directory}: is damaged: the flight of evaluation {index} is missing")
    return stored, flight


def _write_target(directory: Path, study: Study, store: Store, target: str) -> Best:
    """Write ``best/<target>/``."""
    from driftform.figures.section import section_svg
    from driftform.tables.files import write_trajectory
    from driftform.trajectory.approach import closest_approach

    stored, flight = _read_best(directory, study, store, target)
    agent = study.make_pipeline().make_agent(stored.genome)
    [distance], _ = closest_approach(flight, np.array([study.scenario.targets[target]]))
    job = ExportJob("agent", agent, study.scenario, agent_document(stored))
    folder = directory / "best" / target
    files = [folder / "agent.json", folder / "trajectory.csv", folder / "section.svg"]
    write_agent(files[0], stored)
    write_trajectory(files[1], flight)
    write_text(files[2], section_svg(agent, target, study.scenario))
    problems: list[str] = []
    for name in study.run.formats:
        exporter = study.make_exporter(name)
        path = folder / f"agent{exporter.suffix}"
        try:
            with report_faults():
                written = require_files(exporter.write(job, path), exporter)
        except DriftformError as error:
            # An agent that one format cannot hold is no reason to keep back the others.
            problems.append(f"{path}: not written: {error}")
        else:
            files.extend(Path(file.path) for file in written)
    return Best(
        target,
        stored.result["evaluation"],
        stored.result["fitness"],
        float(distance),
        files[0],
        tuple(files),
        tuple(problems),
        stored.result.get("robust", {}),
    )


def _write_overview(directory: Path, study: Study, store: Store) -> None:
    from driftform.figures.gallery import GalleryEntry
    from driftform.figures.overview import overview_svg

    pipeline = study.make_pipeline()
    fitness = pipeline.fitness
    values: dict[str, float] = {}
    flights: list[GalleryEntry] = []
    flown: dict[int, tuple[Agent, Trajectory]] = {}
    for target in study.scenario.targets:
        stored, flight = _read_best(directory, study, store, target)
        # Targets that share an agent share its flight, and are drawn once.
        agent, flight = flown.setdefault(
            stored.result["evaluation"], (pipeline.make_agent(stored.genome), flight)
        )
        values[target] = stored.result["fitness"]
        flights.append(GalleryEntry(target, agent, flight, fitness.measure(values[target]), fitness.unit))
    title = str(study.document.get("title", ""))
    picture = overview_svg(flights, study.scenario, title, describe_worst(fitness, values))
    write_text(directory / "figures" / "overview.svg", picture)


def _write_reach(directory: Path, study: Study, store: Store) -> None:
    from driftform.figures.reach import reach_svg
    from driftform.trajectory.coverage import PipeGrid, map_coverage

    reach = map_coverage(
        track_progress(store.read_trajectories(), store.count_sound(), "flights"),
        PipeGrid.of_scenario(study.scenario),
    )
    title = str(study.document.get("title", ""))
    write_text(directory / "figures" / "reach.svg", reach_svg(reach, study.scenario, title))
