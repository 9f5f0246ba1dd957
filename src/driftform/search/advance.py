"""Advance a run: search to the end of its budget, fly the finalists, write the best agents; and what is best so far."""

import json
import logging
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from hashlib import file_digest
from typing import Any

from driftform.errors import DriftformError, InputError
from driftform.runs.agent_file import StoredAgent
from driftform.runs.directory import DATABASE
from driftform.runs.found import FOUND, write_found
from driftform.runs.run import StoredRun
from driftform.runs.store import Record, Store
from driftform.runs.versions import find_versions
from driftform.search.early_warnings import FIRST, warn_of_rest
from driftform.search.finalists import find_best_agent, fly_finalists
from driftform.search.loop import run_search
from driftform.search.pool import Executor
from driftform.search.results import Best, write_results
from driftform.search.witness import find_difference, find_dissent
from driftform.types import Evaluation
from driftform.util.files import is_file, read_text, write_text
from driftform.water.flow import GridFlow

_log = logging.getLogger(__name__)

ENDED = "ended.json"
"""Name of the file with what a run has ended with, by which it is known that nothing changed since."""


class Observer:
    """Follows a run while it advances; each method does nothing unless it is overridden."""

    def open_search(self, stored: int) -> AbstractContextManager[object]:
        """Return what is entered around the search; ``stored`` evaluations were there before."""
        return nullcontext()

    def record(self, record: Record) -> None:
        """Take one evaluation, stored or new."""

    def end_batch(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Take the evaluations from ``first`` on that the strategy asked for together, after it was told of them."""

    def warn(self, text: str) -> None:
        """Take a line about what is likely to be wrong."""

    def open_finalists(self) -> AbstractContextManager[Callable[[int, int], None]]:
        """Return a context that yields a function of the disturbed flights done, and of their total."""
        return nullcontext(lambda _, __: None)


def search_run(run: StoredRun, executor: Executor, observer: Observer | None = None) -> None:
    """Ask, evaluate and store until the budget is spent; requires the lock of the run.

    Raises InputError if the stored evaluations are not those that the study asks for.
    """
    with run.write() as store:
        _search(run, store, executor, observer or Observer())


def advance_run(run: StoredRun, executor: Executor, observer: Observer | None = None) -> list[Best]:
    """Search to the end of the budget, fly the finalists, and write best agents and maps; requires the lock of the run.

    A run that has ended, and was not changed since, is left as it is.

    Raises:
        InputError: if the stored evaluations are not those that the study asks for.
        WorkFailedError: if every evaluation failed.
    """
    if (ended := find_ended(run)) is not None:
        return ended
    observer = observer or Observer()
    _log.info("%s: search, %d evaluations in all", run.path, run.study.evaluations)
    with run.write() as store:
        _search(run, store, executor, observer)
        _log.info("%s: fly the best agents under disturbed conditions", run.path)
        with observer.open_finalists() as progress:
            fly_finalists(run.study, store, executor, progress)
        store.check_place()
        _log.info("%s: write best agents and pictures", run.path)
        try:
            found = write_results(StoredRun(run.path, run.study), executor)
        except DriftformError:
            store.check_place()
            raise
        winners = {int(best.result["evaluation"]) for best in found}
        for look in (find_difference, find_dissent):
            if line := look(run.study, store, winners):
                observer.warn(line)
    if not any(best.problems for best in found):
        files = {best.target: [path.relative_to(run.path).as_posix() for path in best.files] for best in found}
        results = {best.target: best.result for best in found}
        facts = {**_identify(run), "files": files, "results": results}
        with suppress(OSError):
            write_text(run.path / ENDED, json.dumps(facts, indent=1) + "\n")
    return found


def _identify(run: StoredRun) -> dict[str, Any]:
    """Return the budget of a run, the versions of all that affects what it ends with, and a digest of what is stored."""
    with (run.path / DATABASE).open("rb") as file:
        stored = file_digest(file, "sha256").hexdigest()
    return {"evaluations": run.study.evaluations, "versions": find_versions(run.study.document), "stored": stored}


def find_ended(run: StoredRun) -> list[Best] | None:
    """Return the best agents of a run that has ended and was not changed since, ``None`` for any other.

    What was stored, the versions of all that affects it, and the files of the agents are compared with those of the end.
    """
    found: list[Best] = []
    pictures = [run.path / "figures" / f"{name}.svg" for name in ("overview", "reach")]
    try:
        ended = json.loads(read_text(run.path / ENDED))
        if {**ended, **_identify(run)} != ended:
            return None
        for target, result in ended["results"].items():
            files = tuple(run.path / name for name in ended["files"][target])
            if not all(map(is_file, (*files, *pictures))) or StoredAgent.read(files[0]).result != result:
                return None
            found.append(Best(target, result, files[0], files))
    except (InputError, AttributeError, LookupError, RecursionError, TypeError, ValueError):
        # It has not ended, an agent was changed, or another program wrote these facts.
        return None
    return found


def _search(run: StoredRun, store: Store, executor: Executor, observer: Observer) -> None:
    scenario = run.study.scenario
    if not scenario.pipe.is_open or isinstance(scenario.flow, GridFlow):
        from driftform.water.fittings import fitting_array

        # The flow in tees of a new shape is solved, or a grid read, here and now: what is said would be lost in the display.
        try:
            fitting_array(scenario)
        except ValueError as error:
            if isinstance(scenario.flow, GridFlow):
                raise InputError(f"{run.path}: {error}") from None
            # The flow in a tee of such a shape is not known; a flight says so.
    first: list[Evaluation] = []

    def record(record: Record) -> None:
        observer.record(record)
        if record.index < FIRST:
            first.append(record.evaluation)
            if len(first) == FIRST and (text := warn_of_rest(first, scenario.flight.horizon)):
                observer.warn(text)

    with observer.open_search(store.count()):
        found = run_search(run.study, store, executor, record, observer.end_batch)
    write_found(run.path / FOUND, found)


def find_best(run: StoredRun, target: str) -> StoredAgent | None:
    """Return the best agent of a run for a target, ``None`` while every evaluation has failed."""
    with run.read() as store:
        return find_best_agent(run.study, store, target)


def list_best(run: StoredRun) -> Mapping[str, Mapping[str, Any]]:
    """Return the result of the best agent of each target: fitness (%), error (% of d_max), evaluation."""
    with run.read() as store:
        found = {target: find_best_agent(run.study, store, target) for target in run.study.scenario.targets}
    return {target: stored.result for target, stored in found.items() if stored is not None}
