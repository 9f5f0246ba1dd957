"""Evaluations by groups of workers that share one queue, and the genome to blame when a worker dies.

A worker group is the set of processes within which a death cannot be traced to one task: a local process with its two
tasks, or a whole cluster. A death in one group does not affect the others.
"""

from abc import ABC, abstractmethod
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from enum import Enum
from typing import Any

from driftform.errors import WorkFailedError
from driftform.search.jobs import ATTEMPTS, KILLS, STARTS, Job, Outcome, T, WorkersLostError, task_size
from driftform.types import Evaluation

TASKS_PER_PROCESS = 2
"""Tasks submitted for each process: one running, and one ready to run next."""

POLL_S = 2.0
"""Time between two polls of the worker groups while no task finishes, s."""


class Cause(Enum):
    """What ended a task without a result."""

    NONE = "its process died while the task was waiting"
    START = "its process died before it could evaluate anything"
    CRASH = "its process ended itself"
    KILL = "its process was killed, by somebody or by the kernel, or nobody knows why it died"
    TIMEOUT = "it took longer than allowed"


@dataclass(frozen=True)
class Death:
    """The death of a worker, as one task saw it: its ``cause``, a few words on it, and how many workers died."""

    cause: Cause
    detail: str = ""
    count: int = 1


class WorkerDiedError(WorkFailedError):
    """The worker that had a task died."""

    def __init__(self, death: Death) -> None:
        super().__init__(f"its process died ({death.detail})")
        self.death = death


class Call:
    """One call of :meth:`PoolExecutor.evaluate`: jobs that wait, jobs that run, and outcomes that are not yielded yet."""

    def __init__(self, waiting: deque[Job]) -> None:
        self.waiting = waiting
        self.arrived: list[Outcome] = []
        self._running: dict[int, Job] = {}

    @property
    def is_busy(self) -> bool:
        """True if more outcomes will follow."""
        return bool(self.waiting or self._running or self.arrived)

    def take(self, size: int) -> list[Job]:
        """Return up to ``size`` waiting jobs, which now run."""
        batch = [self.waiting.popleft() for _ in range(min(size, len(self.waiting)))]
        self._running |= {id(job): job for job in batch}
        return batch

    def receive(self, job: Job, evaluation: Evaluation) -> bool:
        """Keep the outcome of a job if it is one of this call; return whether it is."""
        if self._running.pop(id(job), None) is None:
            return False
        self.arrived.append((job.index, evaluation))
        return True


class WorkerGroup(ABC):
    """The processes within which a death cannot be traced to one task.

    A task that had not begun is started again: its genomes are not to blame. If workers die :data:`STARTS` times in a
    row before they begin, the run stops.

    The genomes of a task that had begun are evaluated again one by one. Each then has the group to itself, so that the
    genome to blame is known for certain. It fails if its process ends itself :data:`ATTEMPTS` times. A process that
    is killed was not ended by its genome, unless it takes all memory: the genome fails after :data:`KILLS` times. An
    evaluation that takes longer than ``run.evaluation_timeout`` fails at once.

    Args:
        document: of the study.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.timeout = float(document["run"]["evaluation_timeout"])
        """Time limit of an evaluation, s."""
        self._targets = len(document["targets"])
        self._running: dict[Future[list[Outcome]], Sequence[Job]] = {}
        self._returned: deque[Sequence[Job]] = deque()
        self._suspects: deque[Job] = deque()
        self._runs_suspect = False
        self._deaths: Counter[Cause] = Counter()  # of the genome that is evaluated alone
        self._failed_starts = 0

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

    def find_death(self, error: BaseException) -> Death | None:
        """Return the death that an error of a task reports, ``None`` for any other error."""
        return error.death if isinstance(error, WorkerDiedError) else None

    @abstractmethod
    def close(self) -> None:
        """Stop the workers; their running tasks are lost."""

    def renew(self) -> None:  # noqa: B027 - a cluster may belong to others
        """End the workers, because one of them answered what it was not asked."""

    def poll(self) -> None:  # noqa: B027 - a group may have nothing to check
        """Check the state of the workers; called at least every :data:`POLL_S`."""

    @property
    def running(self) -> Sequence["Future[list[Outcome]]"]:
        """Tasks that are submitted and not collected."""
        return list(self._running)

    @property
    def is_busy(self) -> bool:
        """True if more outcomes will follow."""
        return bool(self._running or self._returned or self._suspects)

    def take(self, call: Call, size: int) -> bool:
        """Start one more task, of up to ``size`` genomes of a call, if the group has room; return whether it started one."""
        if self._suspects:
            if not self._running:
                self._start([self._suspects.popleft()], is_suspect=True)
            return False
        has_room = (
            not (self._runs_suspect and self._running) and len(self._running) < TASKS_PER_PROCESS * self.processes
        )
        if has_room and self._returned:
            self._start(self._returned.popleft(), is_suspect=False)
            return True
        if has_room and call.waiting:
            self._start(call.take(size), is_suspect=False)
            return True
        return False

    def collect(self) -> list[tuple[Job, Evaluation]]:
        """Return the evaluations since the last call, with a failure for each genome to blame.

        Raises:
            WorkersLostError: if workers cannot start.
            Exception: the error of a task, if it is not the death of a worker.
        """
        found: list[tuple[Job, Evaluation]] = []
        for future in [future for future in self._running if future.done()]:
            batch = self._running.pop(future)
            error = self.find_error(future)
            if error is None and not is_answer(batch, future.result()):
                self.renew()
                error = WorkerDiedError(Death(Cause.CRASH, "it answered what it was not asked"))
            if error is None:
                found += [(job, evaluation) for job, (_, evaluation) in zip(batch, future.result(), strict=True)]
                self._deaths.clear()
                self._failed_starts = 0
            elif (death := self.find_death(error)) is None:
                raise error
            elif death.cause in (Cause.NONE, Cause.START):
                self._count_start(death)
                self._give_back(batch)
            elif self._runs_suspect:
                found += self._count_against(batch[0], death)
            else:
                self._suspects.extend(batch)
        return found

    def _start(self, batch: Sequence[Job], is_suspect: bool) -> None:
        self._runs_suspect = is_suspect
        self._running[self.submit(batch)] = batch

    def _give_back(self, batch: Sequence[Job]) -> None:
        if self._runs_suspect:
            self._suspects.extendleft(batch)
        else:
            self._returned.append(batch)

    def _count_start(self, death: Death) -> None:
        self._failed_starts += death.cause is Cause.START
        if self._failed_starts >= STARTS:
            raise WorkersLostError(
                f"workers cannot start here: {STARTS} in a row died before they could evaluate anything "
                f"({death.detail})"
            )

    def _count_against(self, job: Job, death: Death) -> list[tuple[Job, Evaluation]]:
        self._failed_starts = 0
        self._deaths[death.cause] += death.count
        crashes, kills = self._deaths[Cause.CRASH], self._deaths[Cause.KILL]
        if death.cause is Cause.TIMEOUT:
            failure = f"its evaluation did not end within {self.timeout:g} s (run.evaluation_timeout)"
        elif crashes >= ATTEMPTS:
            failure = f"its process died {ATTEMPTS} times ({death.detail})"
        elif kills >= KILLS:
            why = f" ({death.detail})" if death.detail else ""
            failure = f"its process was killed {KILLS} times{why}, from outside or for want of memory"
        else:
            self._suspects.appendleft(job)
            return []
        self._deaths.clear()
        return [(job, Evaluation.failed(job.genome, self._targets, failure))]


def is_answer(batch: Sequence[Job], outcomes: Sequence[Outcome]) -> bool:
    """Return whether outcomes are those of the jobs, in their order."""
    return [(index, evaluation.genome) for index, evaluation in outcomes] == [(job.index, job.genome) for job in batch]


class PoolExecutor(ABC):
    """Evaluates on worker groups that share one queue."""

    def __init__(self, groups: Sequence[WorkerGroup]) -> None:
        self._groups = groups
        self._calls: list[Call] = []
        self._seconds: float | None = None

    def evaluate(self, jobs: "Sequence[Job] | deque[Job]") -> Iterator[list[Outcome]]:
        """Yield the outcomes as they arrive, in any order, in batches of any size.

        Jobs may be added to a deque until the last outcome has arrived, and a call may begin while another is under way: its
        jobs come first, and the workers evaluate those of the other in the time that they have left.
        """
        call = Call(jobs if isinstance(jobs, deque) else deque(jobs))
        self._calls.append(call)
        try:
            while call.is_busy:
                while self._hand_out():
                    pass
                if not call.arrived:
                    self._collect()
                if call.arrived:
                    outcomes, call.arrived = call.arrived, []
                    self._seconds = outcomes[-1][1].seconds or self._seconds
                    yield outcomes
        finally:
            self._calls.remove(call)

    @abstractmethod
    def call(self, functions: Sequence[Callable[[], T]]) -> list[T]:
        """Call functions on this machine; see :class:`driftform.search.jobs.Executor`."""

    def close(self) -> None:
        """Stop the workers; their running tasks are lost."""
        for group in self._groups:
            group.close()

    def _collect(self) -> None:
        """Wait until a task ends, and keep the outcomes for the calls whose jobs they are of."""
        wait([future for group in self._groups for future in group.running], POLL_S, FIRST_COMPLETED)
        for group in self._groups:
            group.poll()
        for group in self._groups:
            for job, evaluation in group.collect():
                # A call that was given up receives nothing.
                any(call.receive(job, evaluation) for call in self._calls)

    def _hand_out(self) -> bool:
        """Start one task in each group that has room; return whether any started one."""
        processes = sum(group.processes for group in self._groups)
        started = []
        for group in self._groups:
            call = next((call for call in reversed(self._calls) if call.waiting), self._calls[-1])
            started.append(group.take(call, task_size(len(call.waiting), processes, self._seconds)))
        return any(started)
