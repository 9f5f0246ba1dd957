"""What a run leaves behind: the best agents with their files, and pictures of all flights."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from driftform.errors import DriftformError, InputError, WorkFailedError
from driftform.figures.gallery import GalleryEntry
from driftform.figures.overview import overview_svg
from driftform.figures.reach import reach_svg
from driftform.figures.section import section_svg
from driftform.interfaces import ExportJob
from driftform.runs.agent_file import agent_document, write_agent
from driftform.runs.finalists import find_best_agent
from driftform.runs.store import Store
from driftform.study import Study
from driftform.tables.files import write_trajectory
from driftform.trajectory.approach import closest_approach
from driftform.trajectory.coverage import PipeGrid, map_coverage
from driftform.util.files import write_text
from driftform.util.progress import track_progress


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


def write_best(directory: Path, study: Study, store: Store) -> list[Best]:
    """Write ``best/<target>/`` for every target, and the overview; return the best agents.

    Raises
    ------
    WorkFailedError
        where not one evaluation succeeded; the message gives the reason of the first.
    InputError
        where a stored evaluation is damaged.
    """
    targets, pipeline = study.scenario.target_names, study.make_pipeline()
    results: list[Best] = []
    flights: list[GalleryEntry] = []
    for target in targets:
        stored = find_best_agent(study, store, target)
        if stored is None:
            first = store.read_record(0, targets).evaluation
            raise WorkFailedError(f"all {store.count()} evaluations failed, the first: {first.failure}")
        index, fitness = stored.result["evaluation"], stored.result["fitness"]
        flight = store.read_record(index, targets).evaluation.trajectory
        if flight is None:
            raise InputError(f"{directory}: is damaged: the flight of evaluation {index} is missing")
        agent = pipeline.make_agent(stored.genome)
        point = np.array([study.scenario.targets[target]])
        distance, _ = closest_approach(flight, point)
        job = ExportJob("agent", agent, study.scenario, agent_document(stored))
        folder = directory / "best" / target
        write_agent(folder / "agent.json", stored)
        write_trajectory(folder / "trajectory.csv", flight)
        write_text(folder / "section.svg", section_svg(agent, target, study.scenario))
        files = [folder / "agent.json", folder / "trajectory.csv", folder / "section.svg"]
        problems: list[str] = []
        for name in study.run.formats:
            exporter = study.make_exporter(name)
            path = folder / f"agent{exporter.suffix}"
            try:
                written = exporter.write(job, path)
            except DriftformError as error:
                # An agent that one format cannot hold is no reason to keep back the others.
                problems.append(f"{path}: not written: {error}")
            else:
                files.extend(Path(file.path) for file in written)
        results.append(
            Best(
                target,
                index,
                fitness,
                float(distance[0]),
                files[0],
                tuple(files),
                tuple(problems),
                stored.result.get("robust", {}),
            )
        )
        flights.append(GalleryEntry(target, agent, flight, results[-1].error_percent))
    overview = directory / "figures" / "overview.svg"
    write_text(overview, overview_svg(flights, study.scenario, str(study.document.get("title", ""))))
    return results


def write_reach(directory: Path, study: Study, store: Store) -> Path:
    """Write the map of what the flights of a run reach, and return its path; flights are read one after the other.

    Raises
    ------
    InputError
        where a stored flight is damaged.
    """
    path = directory / "figures" / "reach.svg"
    reach = map_coverage(
        track_progress(store.read_trajectories(), store.count_sound(), "flights"),
        PipeGrid.of_scenario(study.scenario),
    )
    write_text(path, reach_svg(reach, study.scenario, str(study.document.get("title", ""))))
    return path
