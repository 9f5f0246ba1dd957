"""driftform in notebooks and scripts: from a scenario to an evolved agent to its mesh.

``import driftform as df`` offers :func:`load_study`, :func:`evolve`, :func:`open_run` and :func:`open_agent`. What
they return shows itself in a notebook: a run as its overview and a table of targets, an agent as a drawing of its section, a
flight as its path. Quantities are in SI units, fitness is in percent, frames are those of :mod:`driftform.types`.
"""

import os
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from driftform.design import opening
from driftform.design.design import Design
from driftform.design.flight import Flight
from driftform.design.opening import open_best
from driftform.errors import InputError, did_you_mean
from driftform.runs.agent_file import StoredAgent
from driftform.runs.coverage import CoverageMap
from driftform.runs.misses import Misses
from driftform.runs.run import StoredRun
from driftform.runs.store import Record
from driftform.runs.tables import evaluation_batches, list_columns, write_tables
from driftform.runs.wording import is_promised, list_cells, list_headings
from driftform.search.advance import Observer, advance_run, find_best, list_best
from driftform.search.finalists import find_winner
from driftform.search.local import InProcess, LocalProcesses
from driftform.search.picking import pick_agent, write_pick
from driftform.search.pool import Executor
from driftform.search.report.page import write_report
from driftform.search.results import map_run
from driftform.study import Study, study
from driftform.study.sources import say_in_python
from driftform.types import Evaluation, Trajectory
from driftform.util.notebook import show_picture, show_table
from driftform.util.progress import count_progress
from driftform.water.disturbances import Specimen

__all__ = ["Design", "Flight", "NoTargetError", "Run", "evolve", "load_study", "open_agent", "open_run"]


if TYPE_CHECKING:
    from driftform.study import load_study
else:
    load_study = say_in_python(study.load_study)


OnBatch: TypeAlias = Callable[[int, Sequence[Evaluation]], None]
"""Takes the index of the first evaluation of a batch, and its evaluations."""


class NoTargetError(InputError, KeyError):
    """A run was asked for a target that it does not have."""


class Run(StoredRun, Mapping[str, Design]):
    """A run on disk: the best agent of each target, by the target's name.

    It shows what was stored at the time of asking; ask again while another process continues the run.

    Attributes:
        path: of its directory.
        study: what was searched for: scenario, plugins and their options, seed and budget.
    """

    def __getitem__(self, target: str) -> Design:
        names = self.study.scenario.target_names
        if target not in names:
            raise NoTargetError(f"{self.path} has no target '{target}'{did_you_mean(str(target), names)}")
        return Design.build(open_best(self, target), f"{self.path}:{target}")

    def __iter__(self) -> Iterator[str]:
        return iter(self.study.scenario.target_names)

    def __len__(self) -> int:
        return len(self.study.scenario.target_names)

    def find_best(self, target: str) -> StoredAgent | None:
        """Return the best agent for a target without building it; ``None`` while every evaluation has failed."""
        return find_best(self, target)

    def pick(self, x: float, y: float, z: float) -> Design:
        """Return the agent whose flight passes closest to a point of the world, m; its ``result`` says how close.

        Raises InputError if no flight can pass the point, or every evaluation has failed so far.
        """
        return Design.build(pick_agent(self, (x, y, z)), f"{self.path}: {x:g} {y:g} {z:g}")

    def write_pick(self, x: float, y: float, z: float, folder: Path | None = None) -> Path:
        """Pick an agent as :meth:`pick` does, write it as ``agent.json``, and return its path.

        The ``folder`` is by default ``picks/X_Y_Z`` of the run.
        """
        return write_pick(self, (x, y, z), folder)[1]

    def misses(self, target: str) -> Misses | None:
        """Return how far the disturbed flights of a target's best agent miss; ``None`` before they are flown."""
        with self.read() as store:
            winner = find_winner(self.study, store, target)
        promise = None if winner is None else winner.promises.get(Specimen.PRINT)
        return None if promise is None else promise.misses

    def map_coverage(self) -> CoverageMap:
        """Return which cells of the pipe its flights cross.

        Raises:
            InputError: in open water.
        """
        with self.read() as store:
            return map_run(self.study, store)

    def read_flight(self, evaluation: int) -> Trajectory | None:
        """Return the flight of an evaluation as it was stored; ``None`` if it failed or is not stored."""
        with self.read() as store:
            found = list(store.read_records(self.study.scenario.target_names, evaluation, 1))
        return found[0].evaluation.trajectory if found else None

    def advance(self, executor: Executor, observer: Observer | None = None) -> list[str]:
        """Search until the budget is spent, fly the finalists, and write best agents and pictures.

        For a run that is created or resumed. Returns one line per file that could not be written.

        Raises:
            InputError: if the stored evaluations are not those that the study asks for.
            WorkFailedError: if every evaluation failed.
        """
        return [problem for best in advance_run(self, executor, observer) for problem in best.problems]

    def report(self, path: str | os.PathLike[str] | None = None) -> Path:
        """Write the run as one page that needs no network, and return its path.

        Args:
            path: of the page; ``None`` for ``report.html`` in the run.

        Raises WorkFailedError if no evaluation succeeded yet.
        """
        return write_report(self, None if path is None else Path(path))[1]

    def evaluations(self) -> dict[str, list[Any]]:
        """Return all evaluations as columns, for ``pandas.DataFrame(run.evaluations())``: those of ``export-data``."""
        found: dict[str, list[Any]] = {}
        with self.read() as store:
            records, columns = store.read_records(self.study.scenario.target_names), list_columns(self.study, store)
            for batch in evaluation_batches(self.study, records, columns):
                for name, values in batch.items():
                    found.setdefault(name, []).extend(values)
        return found

    def export_data(
        self, folder: str | os.PathLike[str] | None = None, *, format: str = "csv", trajectories: bool = False
    ) -> dict[str, int]:
        """Write the run as tables, as ``driftform export-data`` does, and return the number of rows of each.

        Args:
            folder: for the files; ``None`` for ``data`` in the run.
            format: ``"csv"`` or ``"parquet"``.
            trajectories: whether the samples of all flights are written too.

        Raises InputError if the format is unknown, or the folder is not empty.
        """
        return write_tables(self, None if folder is None else Path(folder), format, trajectories)

    def best(self) -> Mapping[str, Mapping[str, Any]]:
        """Return the result of the best agent of each target: fitness (%), error (% of d_max), evaluation."""
        return list_best(self)

    def __repr__(self) -> str:
        return f"<Run {self.path}: {len(self)} targets>"

    def _repr_html_(self) -> str:
        places, best, fitness = (self.study.scenario.target_points(), self.best(), self.study.make_plugin("fitness"))
        promised = all(map(is_promised, best.values()))
        rows = (
            (
                target,
                ", ".join(f"{c:g}" for c in places[target]),
                *list_cells(fitness, row, promised),
                str(row["evaluation"]),
            )
            for target, row in best.items()
        )
        header = ("target", "x, y, z m", *list_headings(fitness, promised), "evaluation")
        overview = self.path / "figures" / "overview.svg"
        shown = show_picture(overview.read_text(encoding="utf-8"), repr(self)) if overview.is_file() else ""
        return shown + show_table(header, rows, str(self.path))


class _Counter(Observer):
    """Prints on stderr how many evaluations are done, if it is to, and calls a function for each batch."""

    def __init__(self, budget: int, progress: bool, on_batch: OnBatch | None) -> None:
        self._budget, self._done, self._shows = budget, 0, progress
        self._on_batch = on_batch
        self._progress: Callable[[int, int], None] = lambda _, __: None

    @contextmanager
    def open_search(self, stored: int) -> Iterator[None]:
        with count_progress("evaluations") if self._shows else nullcontext(self._progress) as self._progress:
            yield

    def record(self, record: Record) -> None:
        self._done += 1
        self._progress(self._done, self._budget)

    def end_batch(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        if self._on_batch is not None:
            self._on_batch(first, evaluations)

    def warn(self, text: str) -> None:
        warnings.warn(text, stacklevel=2)

    def open_finalists(self) -> AbstractContextManager[Callable[[int, int], None]]:
        return count_progress("disturbed flights") if self._shows else super().open_finalists()


def evolve(
    study: Study,
    directory: str | os.PathLike[str],
    *,
    workers: int = 1,
    progress: bool = True,
    on_batch: OnBatch | None = None,
) -> Run:
    """Evolve agents for every target of a study, as ``driftform evolve`` does, and return the run.

    A directory that holds a run of the same study is continued: to run a cell again costs nothing, and what was
    interrupted continues where it stopped.

    Args:
        study: from :func:`load_study`; without a seed, each call makes another run.
        directory: where the run is written; see ``docs/dataflow.md`` for its files.
        workers: processes; the result does not depend on it.
        progress: whether the number of evaluations done is printed on stderr.
        on_batch: called after each batch of the search, stored or new, with the arguments of ``Strategy.tell``: the index of
            its first evaluation, and its evaluations.

    Raises:
        InputError: if the study has no targets, not even its smallest agent can be released, or the directory holds
            something else.
        WorkFailedError: if every evaluation failed.

    Warns:
        UserWarning: before the first flight, of what is likely to be wrong with the study, such as targets out of
            reach, as ``driftform scenarios check`` does; if nearly all of the first flights last to the horizon; at the end,
            of evaluations that differ when they are flown again, and of files that could not be written.
    """
    if workers < 1:
        raise InputError(f"workers = {workers}: should be at least 1")
    study.check_search()
    for warning in study.list_warnings():
        warnings.warn(warning, stacklevel=2)
    with Run.create(Path(directory), study, again=True) as run:
        executor = InProcess(study.make_pipeline()) if workers == 1 else LocalProcesses(study.document, workers)
        with closing(executor):
            problems = run.advance(executor, _Counter(study.evaluations, progress, on_batch))
    for problem in problems:
        warnings.warn(problem, stacklevel=2)
    return run


def open_run(directory: str | os.PathLike[str]) -> Run:
    """Open a run directory, also while another process continues it.

    Raises InputError if it is not a run.
    """
    return Run.open(Path(directory))


@say_in_python
def open_agent(
    text: str | os.PathLike[str],
    *settings: str,
    scenario: str | None = None,
    use: Mapping[str, str | None] | None = None,
) -> Design:
    """Build an agent.

    Args:
        text: path of an ``agent.json``, ``RUN:TARGET``, the text of a genome, or ``sphere:40mm``, as the commands take it.
        settings: keys of its study to change, as for :meth:`Design.under`.
        scenario: another scenario than its own, as there.
        use: other plugins than its own, as there.

    Raises InputError if the agent does not exist.
    """
    return opening.open_agent(os.fspath(text), scenario, settings, use)
