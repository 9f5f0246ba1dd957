"""Where evaluations run: local worker processes that may crash without taking the run with them."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import wait as wait_for_any
from typing import TYPE_CHECKING, Any

from driftform.pipeline import Pipeline
from driftform.store import compact
from driftform.study import Document, load_study
from driftform.types import Evaluation, Genome

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

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
            indices, genomes = zip(*batch, strict=True)
            evaluations = self._pipeline.evaluate(genomes, indices)
            yield from ((index, compact(e)) for (index, _), e in zip(batch, evaluations, strict=True))

    def close(self) -> None:
        """Nothing to end."""


class LocalProcesses:
    """Evaluates in a pool of worker processes on this machine.

    A worker that dies (a crash in compiled code, the kernel's memory killer) breaks the whole pool. It is then
    rebuilt, and what was under way at that moment is tried again, one genome after the other in a process of its
    own, so that the one to blame is known for sure; a genome that kills its process :data:`ATTEMPTS` times has
    failed.
    """

    def __init__(self, document: Mapping[str, Any], workers: int) -> None:
        self._document = dict(document)
        self._workers = workers
        self._pool: _Pool | None = None

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
                yield from self._one_by_one([job for batch in suspects for job in batch])

    def close(self) -> None:
        """End the workers; what they were doing is lost."""
        if self._pool is not None:
            self._pool.close()
            self._pool = None

    def _submit(self, batch: Sequence[Job], workers: int | None = None) -> "Future[list[Outcome]]":
        if self._pool is None:
            self._pool = _Pool(self._document, workers or self._workers)
        return self._pool.submit(batch)

    def _one_by_one(self, jobs: Sequence[Job]) -> Iterator[Outcome]:
        for index, genome in jobs:
            for _ in range(ATTEMPTS):
                try:
                    outcomes = self._submit([(index, genome)], workers=1).result()
                    break
                except BrokenProcessPool:
                    self.close()
            else:
                reason = f"its process died {ATTEMPTS} times"
                outcomes = [(index, Evaluation.failed(genome, len(self._document["targets"]), reason))]
            yield from outcomes
        self.close()


def _batches(jobs: Sequence[Job], size: int) -> Iterator[Sequence[Job]]:
    for start in range(0, len(jobs), size):
        yield jobs[start : start + size]


class _Pool:
    """Worker processes that end at once when they are told to, or when this process ends."""

    def __init__(self, document: Mapping[str, Any], workers: int) -> None:
        # Spawned, not forked: the libraries behind the simulators keep threads and global state.
        context = multiprocessing.get_context("spawn")
        # Nothing is ever sent: closing this end is the message.
        ended, self._end = context.Pipe(duplex=False)
        self._ended = ended
        self._executor = ProcessPoolExecutor(
            workers, mp_context=context, initializer=_start, initargs=(dict(document), ended)
        )

    def submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        with _interrupts_held_back():
            return self._executor.submit(_work, batch)

    def close(self) -> None:
        self._end.close()
        self._executor.shutdown(wait=True, cancel_futures=True)
        self._ended.close()


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Worker processes that start meanwhile do not see Ctrl-C: it is the coordinator's to handle.

    They inherit the mask, so that not even one that is still importing answers with a traceback.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


_pipeline: Pipeline | None = None


def _start(document: Mapping[str, Any], ended: "Connection[Any, Any]") -> None:
    global _pipeline  # noqa: PLW0603 - a worker process is one pipeline, made once
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_coordinator, args=(ended,), daemon=True).start()
    _pipeline = load_study(Document("the study", document)).pipeline()


def _end_with_coordinator(ended: "Connection[Any, Any]") -> None:
    """A coordinator that is killed cannot say so, and one that stops does not wait for long flights."""
    parent = multiprocessing.parent_process()
    wait_for_any([ended, *([parent.sentinel] if parent is not None else [])])
    os._exit(1)


def _work(batch: Sequence[Job]) -> list[Outcome]:
    assert _pipeline is not None
    indices, genomes = zip(*batch, strict=True)
    evaluations = _pipeline.evaluate(genomes, indices)
    return [(index, compact(e)) for (index, _), e in zip(batch, evaluations, strict=True)]
