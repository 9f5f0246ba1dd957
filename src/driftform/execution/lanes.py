"""Tasks handed out to lanes of workers, and who is to blame where a worker dies.

A lane is what cannot tell which of its tasks a death was due to: a local process with the task that waits for it, or
a whole cluster. Lanes do not disturb each other.
"""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait

from driftform.execution.jobs import ATTEMPTS, Job, Outcome, task_size
from driftform.types import Evaluation

AHEAD = 2
"""Tasks for each process: one under way, and one that it need not wait for."""

POLL_S = 2.0
"""How often lanes are looked after while nothing comes from them, s."""


class WorkerGroup(ABC):
    """Where tasks run. One that a worker's death took along is tried again, genome by genome.

    While it is, each genome has the lane to itself, so that the one to blame is known for sure; a genome that kills
    its process :data:`ATTEMPTS` times has failed.
    """

    def __init__(self, targets: int) -> None:
        self._targets = targets
        self._running: dict[Future[list[Outcome]], Sequence[Job]] = {}
        self._suspects: deque[Job] = deque()
        self._is_trial = False
        self._deaths = 0  # of the genome on trial

    @property
    @abstractmethod
    def processes(self) -> int:
        """How many genomes are evaluated at the same time."""

    @abstractmethod
    def submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        """Begin a task."""

    def error(self, future: "Future[list[Outcome]]") -> BaseException | None:
        """What a task that is done ended with, ``None`` where all went well."""
        return future.exception()

    @abstractmethod
    def deaths(self, error: BaseException) -> int:
        """How many workers died for a task that ended so; 0 where the error is of another kind."""

    @abstractmethod
    def close(self) -> None:
        """End the workers; what they were doing is lost."""

    def look(self) -> None:  # noqa: B027 - there may be nothing to look after
        """Look after the workers; called now and then."""

    @property
    def running(self) -> Sequence["Future[list[Outcome]]"]:
        """Tasks that are under way or ready."""
        return list(self._running)

    @property
    def is_busy(self) -> bool:
        """Whether there is more to come."""
        return bool(self._running or self._suspects)

    def take(self, waiting: deque[Job], size: int) -> bool:
        """Begin one more task, of ``size`` genomes that wait, where there is room; tell whether it did."""
        if self._suspects:
            if not self._running:
                self._begin([self._suspects.popleft()], is_trial=True)
            return False
        has_room = not (self._is_trial and self._running) and len(self._running) < AHEAD * self.processes
        if has_room and waiting:
            self._begin([waiting.popleft() for _ in range(min(size, len(waiting)))], is_trial=False)
            return True
        return False

    def collect(self) -> list[Outcome]:
        """Return what has come since; a genome that kills its process again and again comes as a failure."""
        outcomes: list[Outcome] = []
        for future in [future for future in self._running if future.done()]:
            batch = self._running.pop(future)
            error = self.error(future)
            if error is None:
                outcomes += future.result()
                self._deaths = 0
            elif not (died := self.deaths(error)):
                raise error
            elif self._is_trial:
                outcomes += self._judge(batch[0], died)
            else:
                self._suspects.extend(batch)
        return outcomes

    def _begin(self, batch: Sequence[Job], is_trial: bool) -> None:
        self._is_trial = is_trial
        self._running[self.submit(batch)] = batch

    def _judge(self, job: Job, died: int) -> list[Outcome]:
        self._deaths += died
        if self._deaths < ATTEMPTS:
            self._suspects.appendleft(job)
            return []
        self._deaths = 0
        return [
            (job.index, Evaluation.failed(job.genome, self._targets, f"its process died {ATTEMPTS} times"))
        ]


class PoolExecutor:
    """Evaluates on lanes that take from one queue."""

    def __init__(self, lanes: Sequence[WorkerGroup]) -> None:
        self._lanes = lanes
        self._seconds: float | None = None

    def evaluate(self, jobs: Sequence[Job]) -> Iterator[list[Outcome]]:
        """Yield the outcomes as they come, in any order, as many at a time as there are."""
        waiting = deque(jobs)
        while waiting or any(lane.is_busy for lane in self._lanes):
            while self._hand_out(waiting):
                pass
            wait([future for lane in self._lanes for future in lane.running], POLL_S, FIRST_COMPLETED)
            for lane in self._lanes:
                lane.look()
            outcomes = [outcome for lane in self._lanes for outcome in lane.collect()]
            if outcomes:
                self._seconds = outcomes[-1][1].seconds or self._seconds
                yield outcomes

    def close(self) -> None:
        """End the workers; what they were doing is lost."""
        for lane in self._lanes:
            lane.close()

    def _hand_out(self, waiting: deque[Job]) -> bool:
        """Let each lane take one task; tell whether any did."""
        processes = sum(lane.processes for lane in self._lanes)
        took = [lane.take(waiting, task_size(len(waiting), processes, self._seconds)) for lane in self._lanes]
        return any(took)
