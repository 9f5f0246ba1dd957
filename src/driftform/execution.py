"""Where evaluations run: local worker processes that may crash without taking the run with them."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import wait as wait_for_any
from typing import Any

from driftform.pipeline import Pipeline
from driftform.store import compact
from driftform.study import Document, load_study
from driftform.types import Evaluation, Genome

Job = tuple[int, Genome]
Outcome = tuple[int, Evaluation]

ATTEMPTS = 2
"""A genome whose process dies this often, alone in it, is recorded as failed."""

BATCH = 8
"""Most genomes in one task: large enough to spread the cost of a task, small enough for a live display."""


class InProcess:
    """Evaluates in this process, one batch at a time: for a handful of genomes, and for debugging."""

    def __init__(self, pipeline: Pipeline) -> None:
        self._pipeline = pipeline

    def evaluate(self, jobs: Sequence[Job]) -> Iterator[Outcome]:
        """Yield the outcomes as they come."""
        for batch in _batches(jobs, BATCH):
            evaluations = self._pipeline.evaluate([genome for _, genome in batch])
            yield from ((index, compact(e)) for (index, _), e in zip(batch, evaluations, strict=True))

    def close(self) -> None:
        """Nothing to end."""


class LocalProcesses:
    """Evaluates in a pool of worker processes on this machine.

    A worker that dies (a crash in compiled code, the kernel's memory killer) breaks the whole pool. It is then
    rebuilt, and what was under way at that moment is tried again, each genome alone in a process, so that the
    one to blame is known for sure; a genome that kills its process :data:`ATTEMPTS` times has failed.
    """

    def __init__(self, document: Mapping[str, Any], workers: int) -> None:
        self._document = dict(document)
        self._workers = workers
        self._pipeline = load_study(Document("the study", document)).pipeline()
        self._pool: ProcessPoolExecutor | None = None

    def evaluate(self, jobs: Sequence[Job]) -> Iterator[Outcome]:
        """Yield the outcomes as they come, in any order."""
        size = max(1, min(BATCH, len(jobs) // (4 * self._workers)))
        queue = deque(_batches(jobs, size))
        running: dict[Future[list[Outcome]], Sequence[Job]] = {}
        while queue or running:
            # No more tasks than workers are handed to the pool: what breaks with it is what was running.
            suspects: list[Sequence[Job]] = []
            while queue and len(running) < self._workers and not suspects:
                batch = queue.popleft()
                try:
                    running[self._submit(batch)] = batch
                except BrokenProcessPool:
                    suspects.append(batch)
            done, _ = wait(running, return_when=FIRST_COMPLETED) if not suspects else ((), ())
            for future in done:
                batch = running.pop(future)
                try:
                    yield from future.result()
                except BrokenProcessPool:
                    suspects.append(batch)
            if suspects:
                suspects.extend(running.values())
                running.clear()
                self.close()
                for batch in suspects:
                    for job in batch:
                        yield from self._alone(job)

    def close(self) -> None:
        """End the workers; what they were doing is lost."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def _submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        if self._pool is None:
            self._pool = _pool(self._document, self._workers)
        return self._pool.submit(_work, batch)

    def _alone(self, job: Job) -> Iterator[Outcome]:
        for _ in range(ATTEMPTS):
            with _pool(self._document, 1) as pool:
                try:
                    yield from pool.submit(_work, [job]).result()
                    return
                except BrokenProcessPool:
                    continue
        index, genome = job
        yield index, self._pipeline.failed(genome, f"its process died {ATTEMPTS} times")


def _batches(jobs: Sequence[Job], size: int) -> Iterator[Sequence[Job]]:
    for start in range(0, len(jobs), size):
        yield jobs[start : start + size]


def _pool(document: Mapping[str, Any], workers: int) -> ProcessPoolExecutor:
    # Spawned, not forked: the libraries behind the simulators keep threads and global state.
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(workers, mp_context=context, initializer=_start, initargs=(dict(document),))


_pipeline: Pipeline | None = None


def _start(document: Mapping[str, Any]) -> None:
    global _pipeline  # noqa: PLW0603 - a worker process is one pipeline, made once
    # Ctrl-C is the coordinator's to handle, which then ends its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _pipeline = load_study(Document("the study", document)).pipeline()


def _end_with_parent() -> None:
    """A coordinator that is killed cannot say so: without this its workers would wait for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait_for_any([parent.sentinel])
        os._exit(1)


def _work(batch: Sequence[Job]) -> list[Outcome]:
    assert _pipeline is not None
    evaluations = _pipeline.evaluate([genome for _, genome in batch])
    return [(index, compact(e)) for (index, _), e in zip(batch, evaluations, strict=True)]
