"""The results of a run: the best agents with their files, and pictures of all flights."""

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from driftform.errors import DriftformError, InputError, WorkFailedError
from driftform.figures.style import SCREEN, Page
from driftform.interfaces import ExportJob
from driftform.plugins.faults import report_faults
from driftform.plugins.seams import require_files
from driftform.runs.agent_file import StoredAgent
from driftform.runs.coverage import CoverageMap, PipeGrid, map_coverage
from driftform.runs.misses import Misses
from driftform.runs.run import StoredRun
from driftform.runs.store import Store
from driftform.runs.wording import summarise
from driftform.search.finalists import Winner, find_best_agent, find_winner
from driftform.search.jobs import ATTEMPTS, WorkerDiedError
from driftform.search.pool import Executor
from driftform.study import Study
from driftform.types import Agent, Trajectory
from driftform.util.files import remove_parts, write_text
from driftform.util.progress import track_progress
from driftform.water.disturbances import Specimen

# Drawing needs the compiled kernels, which take half a second to load. They are imported only inside the functions that
# draw: worker processes, which have loaded them already, call these, and the coordinator starts its workers earlier.

T = TypeVar("T")


@dataclass(frozen=True)
class Best:
    """The best of a run for one target.

    Attributes:
        target: its name.
        result: what the agent's file holds of it: evaluation, fitness (%), misses (m), and promises.
        agent: path of its ``agent.json``.
        files: paths of whatever else was written.
        problems: what could not be written, one line for each.
    """

    target: str
    result: Mapping[str, Any]
    agent: Path
    files: tuple[Path, ...] = ()
    problems: tuple[str, ...] = ()


def write_results(run: StoredRun, executor: Executor) -> list[Best]:
    """Write the best agent of each target, the overview and the map of a run; return the best agents.

    The executor writes them at the same time, each file completely or not at all.
    Raises WorkFailedError with the reason of the first if not one evaluation succeeded, and InputError if one is damaged.
    """
    # The best agents by the evaluation that they share: their flight is read and drawn once.
    shared: dict[int, list[StoredAgent]] = {}
    with run.read() as store:
        for target in run.study.scenario.targets:
            stored = _require_best(run.study, store, target)
            shared.setdefault(stored.result["evaluation"], []).append(stored)
    groups = list(shared.values())
    # What takes longest first.
    pieces: list[Callable[[StoredRun, Store], Any]] = [_write_overview, _write_reach]
    pieces += [partial(_write_agents, stored=group) for group in groups]
    try:
        _, _, *results = executor.call([partial(_call_with_store, write, run) for write in pieces])
        found = {best.target: best for group, _ in results for best in group}
        if run.study.run.formats:
            _export_all(run, executor, groups, [agent for _, agent in results], found)
    except BaseException:
        for folder in ("best", "figures"):
            remove_parts(run.path / folder)
        raise
    return [found[target] for target in run.study.scenario.targets]


def _call_with_store(write: Callable[[StoredRun, Store], T], run: StoredRun) -> T:
    with run.read() as store:
        return write(run, store)


def _require_best(study: Study, store: Store, target: str, winner: Winner | None = None) -> StoredAgent:
    stored = find_best_agent(study, store, target, winner)
    if stored is None:
        reason, count = store.find_commonest_failure()
        raise WorkFailedError(f"all {store.count()} evaluations failed, {count} of them like this: {reason}")
    return stored


def read_flight(run: StoredRun, store: Store, index: int) -> tuple[Trajectory, Mapping[str, float]]:
    """Return the stored flight of an evaluation that did not fail, and its measures. Raises InputError if it is missing."""
    evaluation = store.read_record(index, run.study.scenario.target_names).evaluation
    if evaluation.trajectory is None:
        raise InputError(f"{run.path}: is damaged: the flight of evaluation {index} is missing")
    return evaluation.trajectory, evaluation.measures


def _write_agents(run: StoredRun, store: Store, stored: Sequence[StoredAgent]) -> tuple[list[Best], Agent]:
    """Write ``best/<target>/`` of targets that share an agent, without the files of exporters; return it for these."""
    from driftform.figures.section import section_svg
    from driftform.runs.table_files import write_trajectory

    flight, _ = read_flight(run, store, stored[0].result["evaluation"])
    agent = run.study.make_pipeline().make_agent(stored[0].genome)
    names = ("agent.json", "trajectory.csv", "section.svg")
    found: list[Best] = []
    for best in stored:
        target, result = best.result["target"], best.result
        document, samples, picture = files = [run.path / "best" / target / name for name in names]
        best.write(document)
        write_trajectory(samples, flight)
        write_text(picture, section_svg(agent, target, run.study.scenario))
        found.append(Best(target, result, document, tuple(files)))
    return found, agent


Exports = dict[str, tuple[list[Path], list[str]]]
"""Of each target the files that exporters wrote, and what could not be written, one line each."""


def _export_all(
    run: StoredRun,
    executor: Executor,
    groups: Sequence[Sequence[StoredAgent]],
    agents: Sequence[Agent],
    found: dict[str, Best],
) -> None:
    """Write the formats of the run, and add their files to the best agents.

    An exporter may take its process with it. Then everything else is written already.
    """
    count = 0
    try:
        for exports in executor.call(
            [partial(_export_agent, run, agent, group) for agent, group in zip(agents, groups, strict=True)]
        ):
            count += 1
            for target, (files, problems) in exports.items():
                best = found[target]
                found[target] = replace(best, files=(*best.files, *files), problems=tuple(problems))
    except WorkerDiedError as error:
        target = groups[count][0].result["target"]
        formats = ",".join(run.study.run.formats)
        problem = (
            f"{run.path / 'best' / target}: not all of {formats} was written: its process died {ATTEMPTS} times "
            f"({error.detail}); write what is missing with: driftform export {run.path}:{target} --format {formats}"
        )
        found[target] = replace(found[target], problems=(problem,))


def _export_agent(run: StoredRun, agent: Agent, stored: Sequence[StoredAgent]) -> Exports:
    """Write the formats of the run into ``best/<target>/`` of targets that share an agent."""
    exporters = [run.study.make_exporter(name) for name in run.study.run.formats]
    exported: Exports = {}
    for best in stored:
        opened = shlex.quote(f"{run.path}:{best.result['target']}")
        job = ExportJob("agent", agent, run.study.scenario, best.document(), opened)
        files, problems = exported.setdefault(best.result["target"], ([], []))
        for exporter in exporters:
            path = run.path / "best" / best.result["target"] / f"agent{exporter.suffix}"
            try:
                with report_faults():
                    written = require_files(exporter.write(job, path), exporter)
            except DriftformError as error:
                # An agent that one format cannot hold is no reason to keep back the others.
                problems.append(f"{path}: not written: {error}")
            else:
                files.extend(Path(file.path) for file in written)
    return exported


@dataclass(frozen=True, eq=False)
class BestFlight:
    """The best agent for a target with its flight, which is closest to the target at the time ``t`` (s), at a ``distance`` (m).

    ``measures`` are those of its evaluation; ``misses`` those of its disturbed flights, if it was chosen by them.
    """

    stored: StoredAgent
    agent: Agent
    trajectory: Trajectory
    measures: Mapping[str, float]
    distance: float
    t: float
    misses: Misses | None

    @property
    def target(self) -> str:
        """The target."""
        return str(self.stored.result["target"])

    @property
    def index(self) -> int:
        """The index of its evaluation."""
        return int(self.stored.result["evaluation"])


def read_best(run: StoredRun, store: Store) -> list[BestFlight]:
    """Return the best agent for each target of a run; targets that share an agent share its objects.

    Raises WorkFailedError where not one evaluation succeeded.
    """
    from driftform.motion.path.targets import approach_targets

    pipeline, found, scenario = run.study.make_pipeline(), [], run.study.scenario
    flown: dict[int, tuple[Agent, Trajectory, Mapping[str, float]]] = {}
    for number, target in enumerate(scenario.target_names):
        winner = find_winner(run.study, store, target)
        stored = _require_best(run.study, store, target, winner)
        index = stored.result["evaluation"]
        if index not in flown:
            flown[index] = pipeline.make_agent(stored.genome), *read_flight(run, store, index)
        promise = None if winner is None else winner.promises.get(Specimen.PRINT)
        distance, t = (float(values[number]) for values in approach_targets(flown[index][1], scenario))
        found.append(BestFlight(stored, *flown[index], distance, t, None if promise is None else promise.misses))
    return found


def draw_overview(study: Study, best: Sequence[BestFlight], page: Page = SCREEN) -> str:
    """Return the picture of the best flights and bodies."""
    from driftform.figures.gallery import GalleryEntry
    from driftform.figures.overview import overview_svg

    fitness = study.make_plugin("fitness")
    results = {one.target: one.stored.result for one in best}
    flights = [
        GalleryEntry(target, one.agent, one.trajectory, fitness.measure(result["fitness"]), fitness.unit)
        for one, (target, result) in zip(best, results.items(), strict=True)
    ]
    return overview_svg(flights, study.scenario, study.title, summarise(fitness, results), page)


def _write_overview(run: StoredRun, store: Store) -> None:
    write_text(run.path / "figures" / "overview.svg", draw_overview(run.study, read_best(run, store)))


def _write_reach(run: StoredRun, store: Store) -> None:
    from driftform.figures.reach import reach_svg

    picture = reach_svg(map_run(run.study, store), run.study.scenario, run.study.title)
    write_text(run.path / "figures" / "reach.svg", picture)


def map_run(study: Study, store: Store) -> CoverageMap:
    """Return the coverage of all flights of a run that did not fail. Raises InputError in open water."""
    flights = track_progress(store.read_trajectories(), store.count() - store.count_failed(), "flights")
    return map_coverage(flights, PipeGrid.of_scenario(study.scenario))
