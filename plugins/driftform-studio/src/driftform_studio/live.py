"""A run for the page: the progress of its search, its best flights, and the promises of its best agents."""

from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from driftform import Design, Run, StoredAgent
from driftform.errors import InputError
from driftform.figures import scene
from driftform.util import files
from driftform_studio.folder import DATABASE
from driftform_studio.searches import PAUSE, PROGRESS, Searches

RUNNING, WRITING, FINISHED, STOPPED = "running", "writing the best agents", "finished", "stopped"
"""States of the monitor of a run."""

STARTING, PAUSING, PAUSED, FAILED = "starting", "pausing", "paused", "failed"
"""States that the page has besides these."""

PATH_TOLERANCE = 2e-3
"""Tolerance to which a path is simplified for a side view, m: a tenth of the detail that a screen shows of a pipe."""


class LiveRun:
    """A run that the page has open; results are kept, and only new ones are read."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self._lock = Lock()
        self._run: Run | None = None
        self._monitor: Any = None
        self._best: dict[str, tuple[tuple[Any, ...], dict[str, Any]]] = {}
        self._place = files.identify_file(directory / DATABASE)

    def exists(self) -> bool:
        """Return whether the run is still the one that was opened."""
        return files.identify_file(self.directory / DATABASE) == self._place

    @property
    def run(self) -> Run:
        """The run, opened to be read. Raises InputError if its study cannot be carried out here."""
        with self._lock:
            if self._run is None:
                self._run = Run.open(self.directory, check=False)
                self._monitor = self._run.monitor()
            return self._run

    def read_status(self, searches: Searches) -> dict[str, Any]:
        """Return the progress of the search. Raises InputError if the run is damaged."""
        run = self.run
        with self._lock:
            monitor = self._monitor
            monitor.poll()
            status = monitor.status
            disturbed = self._count_disturbed(run)
            targets: list[dict[str, Any]] = []
            for name, target in status.targets.items():
                if target.index < 0:
                    targets.append({"name": name, "evaluation": None, "curve": []})
                    continue
                result = self._read_result(run, name, (target.index, monitor.state, disturbed))
                curve = [None if error is None else round(error, 5) for error in target.list_errors()]
                targets.append({"name": name, "curve": curve, **result})
            failure = searches.read_failure(self.directory)
            state = self._name_state(run, searches, failure, targets)
            throughput = monitor.throughput
            return {
                "state": state,
                "canPause": state in (STARTING, RUNNING, WRITING) and searches.can_pause(self.directory),
                "done": status.done,
                "budget": status.budget,
                "failed": status.failed,
                "commonestFailure": (run.describe_failures() or {}).get("reason") if status.failed else None,
                "disturbed": disturbed,
                "compiling": [] if status.done else searches.read_compilation(self.directory),
                "rate": throughput.measure(status.done) if state == RUNNING else None,
                "targets": targets,
                "failure": failure,
            }

    def _name_state(self, run: Run, searches: Searches, failure: str, targets: list[dict[str, Any]]) -> str:
        state = self._monitor.state
        if state in (RUNNING, WRITING):
            return PAUSING if (self.directory / PAUSE).exists() else state
        if searches.is_alive(self.directory):
            return STARTING
        if failure:
            return FAILED
        # The search writes its best agents, and flies them under disturbed conditions if it is to.
        flies = run.study.scenario.robustness.conditions > 0
        is_promised = all("flights" in target.get("robust", {}) for target in targets) or not flies
        written = (run.path / "best" / target["name"] / "agent.json" for target in targets)
        return FINISHED if state != STOPPED and is_promised and all(path.is_file() for path in written) else PAUSED

    def _count_disturbed(self, run: Run) -> list[int]:
        """Return the number of disturbed flights done, and of all, as the search has stated."""
        try:
            done, total = map(int, (self.directory / PROGRESS).read_text(encoding="utf-8").split())
        except (OSError, ValueError):
            with run.read() as store:
                return [len(store.list_disturbed()), 0]
        return [done, total]

    def _read_result(self, run: Run, target: str, state: tuple[Any, ...]) -> dict[str, Any]:
        """Return the result of the best agent of a target; read again only in another state of the run."""
        known = self._best.get(target)
        if known is None or known[0] != state:
            stored = run.find_best(target)
            assert stored is not None
            known = self._best[target] = state, dict(stored.result)
        return known[1]

    def find_agent(self, key: str) -> Design:
        """Return the agent that a key names: the target of a best one, or ``X_Y_Z`` of one that was picked.

        Raises InputError if it does not exist.
        """
        run = self.run
        if key in run.study.scenario.targets:
            return run[key]
        picks = self.directory / "picks"
        known = {path.name: path for path in picks.iterdir()} if picks.is_dir() else {}
        path = known.get(key, picks) / "agent.json"
        if key not in known or path.resolve().parent.parent.parent != self.directory.resolve():
            raise InputError(f"{self.directory.name}: has no agent '{key}'")
        return Design.build(StoredAgent.read(path), f"{run.name}: {key}")

    def read_path(self, evaluation: int) -> list[list[float]]:
        """Return the path of an evaluation's flight, m, simplified. Raises InputError if there is no such flight."""
        flight = self.run.read_flight(evaluation)
        if flight is None:
            raise InputError(f"{self.directory.name}: has no flight {evaluation}")
        side = flight.position[:, [0, 2]]
        kept = scene.simplify_polyline(side, PATH_TOLERANCE)
        # Simplifying keeps points of the path, whose other coordinate is that of the sample.
        nearest = [int(np.argmin(((side - point) ** 2).sum(axis=1))) for point in kept]
        path: list[list[float]] = np.round(flight.position[nearest], 4).tolist()
        return path
