"""What an executor takes and gives, and how many genomes make one task."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from driftform.errors import WorkFailedError
from driftform.pipeline import Pipeline
from driftform.trajectory.compression import compress_evaluation
from driftform.types import Evaluation, Genome


@dataclass(frozen=True, slots=True)
class Job:
    """What is to be evaluated.

    ``index`` says which of the jobs an outcome belongs to. ``seed`` is that of the gusts, ``None`` for those of the
    scenario; ``condition`` is the number of a disturbed condition, ``None`` for none.
    """

    index: int
    genome: Genome
    seed: int | None = None
    condition: int | None = None


Outcome = tuple[int, Evaluation]


class Executor(Protocol):
    """Where evaluations run."""

    def evaluate(self, jobs: Sequence[Job]) -> Iterable[Sequence[Outcome]]:
        """Yield an outcome for each job, in any order, as many at a time as there are."""


ATTEMPTS = 2
"""A genome whose process dies this often, alone in it, is recorded as failed."""

BATCH = 50
"""Most genomes in one task."""

FIRST = 4
"""Genomes in a task as long as nobody knows how long one takes."""

SHORTEST = 0.02
"""Tasks take this long at least, s: many times what it costs to hand one out."""

LONGEST = 1.0
"""Tasks take no longer than this, s, but for one of a single genome: it is what a crash makes one do again."""


class WorkersLostError(WorkFailedError):
    """What evaluates has gone, and not by anything that was evaluated; a run can go on later."""


def evaluate_batch(pipeline: Pipeline, batch: Sequence[Job]) -> list[Outcome]:
    """Evaluate the genomes of one task, as a run keeps them."""
    evaluations = pipeline.evaluate(
        [job.genome for job in batch], [job.seed for job in batch], [job.condition for job in batch]
    )
    return [
        (job.index, compress_evaluation(evaluation))
        for job, evaluation in zip(batch, evaluations, strict=True)
    ]


def task_size(waiting: int, processes: int, seconds: float | None) -> int:
    """Genomes in the next task: half of an even share of what waits, within what a task may last.

    Tasks get smaller towards the end, so that the processes finish together (Hummel, Schonberg and Flynn 1992,
    Factoring: a method for scheduling parallel loops, doi:10.1145/135226.135232, whose factor of two this is).

    Parameters
    ----------
    waiting
        genomes that nobody has yet.
    processes
        how many evaluate at the same time.
    seconds
        that a genome takes, ``None`` where it is not known.

    >>> [task_size(n, 2, 0.005) for n in (100, 75, 20, 6, 1)]
    [25, 19, 5, 4, 1]
    >>> task_size(1000, 2, 0.005), task_size(1000, 2, 0.2), task_size(1000, 2, 60.0), task_size(1000, 2, None)
    (50, 5, 1, 4)
    """
    share = math.ceil(waiting / (2 * processes))
    if seconds is None:
        return min(share, FIRST)
    seconds = max(seconds, 1e-6)
    size = min(max(share, math.ceil(SHORTEST / seconds)), int(LONGEST / seconds), BATCH, waiting)
    return max(size, 1)
