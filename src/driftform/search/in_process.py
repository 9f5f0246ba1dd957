"""Evaluations in this process, for a few genomes."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence

from driftform.pipeline import Pipeline
from driftform.search.jobs import Job, Outcome, T, evaluate_batch, task_size
from driftform.util.files import keep_directory


class InProcess:
    """Evaluates in this process, one task at a time: for a few genomes, and for debugging."""

    def __init__(self, pipeline: Pipeline) -> None:
        self._pipeline = pipeline
        self._seconds: float | None = None

    def evaluate(self, jobs: "Sequence[Job] | deque[Job]") -> Iterator[list[Outcome]]:
        """Yield the outcomes of one task after another; see :meth:`driftform.search.jobs.Executor.evaluate`."""
        waiting = jobs if isinstance(jobs, deque) else deque(jobs)
        while waiting:
            size = task_size(len(waiting), 1, self._seconds)
            with keep_directory():
                outcomes = evaluate_batch(self._pipeline, [waiting.popleft() for _ in range(size)])
            self._seconds = outcomes[0][1].seconds
            yield outcomes

    def call(self, functions: Sequence[Callable[[], T]]) -> list[T]:
        """Call functions one after the other, and return what they return."""
        with keep_directory():
            return [function() for function in functions]

    def close(self) -> None:
        """Do nothing: there are no workers to stop."""
