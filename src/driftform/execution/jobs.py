"""What an executor takes and gives, and how many genomes make one task."""

import math
from collections.abc import Sequence

from driftform.errors import WorkFailedError
from driftform.packed_flight import compact
from driftform.pipeline import Pipeline
from driftform.types import Evaluation, Genome

Job = tuple[int, Genome]
"""Index of the evaluation in the run, and what is to be evaluated."""

Outcome = tuple[int, Evaluation]

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


class LostError(WorkFailedError):
    """What evaluates has gone, and not by anything that was evaluated; a run can go on later."""


def evaluated(pipeline: Pipeline, batch: Sequence[Job]) -> list[Outcome]:
    """Evaluate the genomes of one task, as a run keeps them."""
    indices, genomes = zip(*batch, strict=True)
    return list(zip(indices, map(compact, pipeline.evaluate(genomes, indices)), strict=True))


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
