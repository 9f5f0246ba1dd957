"""The jobs and outcomes of an executor, and the number of genomes in one task."""

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from enum import Enum
from typing import TypeVar

import numpy as np

from driftform.errors import WorkFailedError, describe_error
from driftform.pipeline import Pipeline
from driftform.runs.compression import compress_evaluation
from driftform.types import Evaluation, Genome
from driftform.water import Scenario
from driftform.water.disturbances import Condition, draw_conditions

T = TypeVar("T")


@dataclass(frozen=True)
class Job:
    """One genome to evaluate.

    Attributes:
        index: identifies the job in its outcome.
        genome: the genome.
        seed: seed of the gusts, ``None`` for that of the scenario.
        condition: disturbed conditions of the flight, ``None`` for undisturbed.
        threshold: for each target the fitness (%) that the genome must exceed to matter, ``None`` if every fitness
            matters; see :meth:`driftform.pipeline.Pipeline.evaluate`.
        wanted: for each target whether a disturbed flight is for it, ``None`` if it is for all; it may stop after the last.
    """

    index: int
    genome: Genome
    seed: int | None = None
    condition: Condition | None = None
    threshold: tuple[float, ...] | None = None
    wanted: tuple[bool, ...] | None = None


Outcome = tuple[int, Evaluation]
"""The index of a job, and its evaluation."""


ATTEMPTS = 5
"""A genome fails if its process dies this often while it evaluates this genome alone: nobody kills so steadily from outside,
but a crash does, or the kernel if the genome takes all memory. A run stops if this many workers in a row, for each process,
die before they can evaluate anything."""

MAX_BATCH = 50
"""Largest number of genomes in one task."""

FIRST_BATCH = 4
"""Largest number of genomes in a task while the time for one is unknown."""

MIN_TASK_S = 0.005
"""Shortest duration of a task, s: ten times the cost of submitting one."""

MAX_TASK_S = 1.0
"""Longest duration of a task of several genomes, s: the work that a crash repeats."""


class WorkersLostError(WorkFailedError):
    """The workers are lost, and no genome is to blame; the run can be resumed."""


class Cause(Enum):
    """What ended a task without a result."""

    NONE = "its process died while the task was waiting"
    START = "its process died before it could evaluate anything"
    DEATH = "its process ended itself, or was killed, by somebody or by the kernel"
    TIMEOUT = "it took longer than allowed"


class WorkerDiedError(WorkFailedError):
    """The process that had a task died: the ``cause``, as this task saw it, and a few words on it."""

    def __init__(self, cause: Cause, detail: str = "") -> None:
        # The arguments as they are: a worker of a cluster sends this error on.
        super().__init__(cause, detail)
        self.cause, self.detail = cause, detail

    def __str__(self) -> str:
        return f"its process died ({self.detail})"


def evaluate_batch(pipeline: Pipeline, batch: Sequence[Job]) -> list[Outcome]:
    """Evaluate the genomes of one task.

    Trajectories are compressed as a run stores them. Of a disturbed flight a run stores no more than its offsets from the targets.
    """
    evaluations = pipeline.evaluate(
        [job.genome for job in batch],
        [job.seed for job in batch],
        [job.condition for job in batch],
        [job.threshold for job in batch],
        [job.wanted for job in batch],
    )
    return [
        (job.index, _reduce(evaluation, job, pipeline.scenario))
        for job, evaluation in zip(batch, evaluations, strict=True)
    ]


def rehearse(pipeline: Pipeline, flies: bool = True) -> None:
    """Fly a random genome under a disturbed condition, if a run with this scenario has any, and forget the flight.

    Disturbed flights need kernels of their own, and a run asks for them only after its undisturbed flights. The one process
    that ``flies`` compiles them while another compiles those of the undisturbed flights.
    """
    robustness, calibration = pipeline.scenario.robustness, pipeline.scenario.calibration
    if flies and robustness.conditions:
        genome = pipeline.grammar.random(np.random.default_rng(0))
        pipeline.evaluate([genome], conditions=draw_conditions(robustness, 1, (0,), calibration))


def _reduce(evaluation: Evaluation, job: Job, scenario: Scenario) -> Evaluation:
    """Return what a run stores of an evaluation, and how it passes the targets, which the coordinator need not find."""
    # Imported here: it loads the compiler.
    from driftform.motion.path.targets import find_offsets

    if job.condition is not None:
        return replace(evaluation, offsets=find_offsets(evaluation, scenario), trajectory=None)
    try:
        compressed = compress_evaluation(evaluation)
        # Of the samples as they are read back, so that a strategy receives the same live and resumed. They stay in the copy.
        offsets = find_offsets(replace(compressed, trajectory=copy(compressed.trajectory)), scenario)
        return replace(compressed, offsets=offsets)
    except ValueError as error:
        failed = Evaluation.failed(evaluation.genome, len(evaluation.fitness), describe_error(error))
        return replace(failed, seconds=evaluation.seconds)


def task_size(waiting: int, processes: int, seconds: float | None) -> int:
    """Return the number of genomes in the next task: half of an even share, within the limits on a task's duration.

    Tasks become smaller towards the end, so that the processes finish together. The factor of two is that of Hummel,
    Schonberg and Flynn (1992), Factoring: a method for scheduling parallel loops, doi:10.1145/135226.135232.

    Args:
        waiting: number of genomes that are not in a task yet.
        processes: number of processes that evaluate at the same time.
        seconds: time for one genome, s, ``None`` if unknown.

    >>> [task_size(n, 2, 0.005) for n in (100, 75, 20, 6, 1)]
    [25, 19, 5, 2, 1]
    >>> task_size(1000, 2, 0.005), task_size(1000, 2, 0.2), task_size(1000, 2, 60.0), task_size(1000, 2, None)
    (50, 5, 1, 4)
    """
    share = math.ceil(waiting / (2 * processes))
    if seconds is None:
        return min(share, FIRST_BATCH)
    seconds = max(seconds, 1e-6)
    size = min(max(share, math.ceil(MIN_TASK_S / seconds)), int(MAX_TASK_S / seconds), MAX_BATCH, waiting)
    return max(size, 1)
