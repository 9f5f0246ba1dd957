"""Evaluations by groups of workers that share one queue, and the genome to blame when a worker dies.

A worker group is the set of processes within which a death cannot be traced to one task: a local process with its two
tasks, or a whole cluster. A death in one group does not affect the others.
"""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait

from driftform.execution.jobs import ATTEMPTS, Job, Outcome, T, task_size
from driftform.types import Evaluation

TASKS_PER_PROCESS = 2
"""Tasks submitted for each process: one running, and one ready to run next."""

POLL_S = 2.0
"""Time between two polls of the worker groups while no task finishes, s."""


class WorkerGroup(ABC):
    """The processes within which a death cannot be traced to one task.

    The genomes of the tasks that a death interrupted are evaluated again one by one. Each then has the group to
    itself, so that the genome to blame is known for certain. A genome whose process dies :data:`ATTEMPTS` times fails.
    """

    def __init__(self, targets: int) -> None:
        self._targets = targets
        self._running: dict[Future[list[Outcome]], Sequence[Job]] = {}
        self._suspects: deque[Job] = deque()
        self._runs_suspect = False
        self._deaths = 0  # of the genome that is evaluated alone

    @property
    @abstractmethod
    def processes(self) -> int:
        """Number of genomes that are evaluated at the same time."""

    @abstractmethod
    def submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        """Start a task."""

    def find_error(self, future: "Future[list[Outcome]]") -> BaseException | None:
        """Return the error of a finished task, ``None`` if it succeeded."""
        return future.exception()

    @abstractmethod
    def count_deaths(self, error: BaseException) -> int:
        """Return how many workers died if this error of a task means deaths, else 0."""

    @abstractmethod
    def close(self) -> None:
        """Stop the workers; their running tasks are lost."""

    def poll(self) -> None:  # noqa: B027 - a group may have nothing to check
        """Check the state of the workers; called at least every :data:`POLL_S`."""

    @property
    def running(self) -> Sequence["Future[list[Outcome]]"]:
        """Tasks that are submitted and not collected."""
        return list(self._running)

    @property
    def is_busy(self) -> bool:
        """True if more outcomes will follow."""
        return bool(self._running or self._suspects)

    def take(self, waiting: deque[Job], size: int) -> bool:
        """Start one more task, of up to ``size`` waiting genomes, if the group has room; return whether it started one."""
        if self._suspects:
            if not self._running:
                self._start([self._suspects.popleft()], is_suspect=True)
            return False
        has_room = (
            not (self._runs_suspect and self._running)
            and len(self._running) < TASKS_PER_PROCESS * self.processes
        )
        if has_room and waiting:
            self._start([waiting.popleft() for _ in range(min(size, len(waiting)))], is_suspect=False)
            return True
        return False

    def collect(self) -> list[Outcome]:
        """Return the outcomes since the last call, with a failure for a genome that killed its process too often.

        Raises
        ------
        Exception
            the error of a task, if it is not the death of a worker.
        """
        outcomes: list[Outcome] = []
        for future in [future for future in self._running if future.done()]:
            batch = self._running.pop(future)
            error = self.find_error(future)
            if error is None:
                outcomes += future.result()
                self._deaths = 0
            elif not (died := self.count_deaths(error)):
                raise error
            elif self._runs_suspect:
                outcomes += self._count_against(batch[0], died)
            else:
                self._suspects.extend(batch)
        return outcomes

    def _start(self, batch: Sequence[Job], is_suspect: bool) -> None:
        self._runs_suspect = is_suspect
        self._running[self.submit(batch)] = batch

    def _count_against(self, job: Job, died: int) -> list[Outcome]:
        self._deaths += died
        if self._deaths < ATTEMPTS:
            self._suspects.appendleft(job)
            return []
        self._deaths = 0
        return [
            (job.index, Evaluation.failed(job.genome, self._targets, f"its process died {ATTEMPTS} times"))
        ]


class PoolExecutor:
    """Evaluates on worker groups that share one queue."""

    def __init__(self, groups: Sequence[WorkerGroup]) -> None:
        self._groups = groups
        self._seconds: float | None = None

    def evaluate(self, jobs: Sequence[Job]) -> Iterator[list[Outcome]]:
        """Yield the outcomes as they arrive, in any order, in batches of any size."""
        waiting = deque(jobs)
        while waiting or any(group.is_busy for group in self._groups):
            while self._hand_out(waiting):
                pass
            wait([future for group in self._groups for future in group.running], POLL_S, FIRST_COMPLETED)
            for group in self._groups:
                group.poll()
            outcomes = [outcome for group in self._groups for outcome in group.collect()]
            if outcomes:
                self._seconds = outcomes[-1][1].seconds or self._seconds
                yield outcomes

    def call(self, functions: Sequence[Callable[[], T]]) -> list[T]:
        """Call functions in this process, because the workers may be on other machines; return what they return."""
        return [function() for function in functions]

    def close(self) -> None:
        """Stop the workers; their running tasks are lost."""
        for group in self._groups:
            group.close()

    def _hand_out(self, waiting: deque[Job]) -> bool:
        """Start one task in each group that has room; return whether any started one."""
        processes = sum(group.processes for group in self._groups)
        started = [
            group.take(waiting, task_size(len(waiting), processes, self._seconds)) for group in self._groups
        ]
        return any(started)
