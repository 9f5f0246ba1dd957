"""Pick the agent of a run whose flight passes closest to a point, also to a point that was not a target."""

import tomllib
from collections import deque
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

import numpy as np

from driftform.errors import InputError
from driftform.pipeline import Pipeline
from driftform.runs.agent_file import StoredAgent
from driftform.runs.compression import compress_evaluation
from driftform.runs.coverage import ClosestPass, find_passes
from driftform.runs.run import StoredRun
from driftform.runs.store import Store
from driftform.util.files import make_directory
from driftform.util.progress import track_progress
from driftform.water import Pipe, Scenario
from driftform.water.pipe import Vector
from driftform.water.places import find_nearest_inside, resolve_place


def pick_agent(run: StoredRun, point: Vector) -> StoredAgent:
    """Return the agent whose flight passes closest to a point of the world (m).

    Its ``result`` holds the point, the distance (m), when it passes (``t``, s) and its evaluation. If the stored flight
    is unchecked, the agent is flown again, and the distance is that of its checked flight.

    Raises InputError if no flight can pass the point, or every evaluation has failed so far.
    """
    check_point(point, run.study.scenario)
    with run.read() as store:
        passes = find_passes(
            track_progress(store.read_trajectories(), store.count() - store.count_failed(), "flights"), point
        )
        found = _check_closest(run, store, passes, point)
        if found is None:
            raise run.refuse_unsound()
        genome = store.read_record(found.evaluation, run.study.scenario.target_names).candidate.genome
    result = {"point": list(point), "distance": found.distance, "t": found.t, "evaluation": found.evaluation}
    name = f"{run.name}-{name_point(point)}"
    return StoredAgent(name, genome, run.study.environment(found.evaluation), result)


def _check_closest(run: StoredRun, store: Store, passes: Sequence[ClosestPass], point: Vector) -> ClosestPass | None:
    """Return the closest of some passes, in ascending order, after unchecked ones that seem closer are flown again."""
    pipeline: Pipeline | None = None
    waiting, closest = deque(passes), None
    while waiting and (closest is None or waiting[0].distance < closest.distance):
        found = waiting.popleft()
        if not found.checked:
            pipeline = pipeline or run.study.make_pipeline()
            record = store.read_record(found.evaluation, run.study.scenario.target_names)
            [evaluation] = pipeline.evaluate([record.candidate.genome], [record.seed])
            flight = compress_evaluation(evaluation).trajectory
            if evaluation.failure is not None or flight is None:
                continue
            [found] = find_passes([(found.evaluation, flight)], point)
        if closest is None or found.distance < closest.distance:
            closest = found
    return closest


def write_pick(run: StoredRun, point: Vector, folder: Path | None = None) -> tuple[StoredAgent, Path]:
    """Pick an agent, and write it as ``agent.json`` into a folder, by default ``picks/X_Y_Z`` of the run."""
    stored = pick_agent(run, point)
    path = make_directory(folder or run.path / "picks" / name_point(point)) / "agent.json"
    stored.write(path)
    return stored, path


def find_place(text: str, pipe: Pipe) -> Vector:
    """Return the point (m) of a place in a pipe, given as the inside of an inline table of TOML.

    Raises InputError if it is not a place in the pipe.
    """
    try:
        place = tomllib.loads(f"place = {{ {text} }}")["place"]
        x, y, z = resolve_place(place, pipe.layout)
    except ValueError as error:
        raise InputError(f"--place {text}: {error}") from None
    return x, y, z


def name_point(point: Vector) -> str:
    """Return a point as a name of a folder.

    >>> name_point((4.5, 0.0, -0.25))
    '4.5_0_-0.25'
    """
    return "_".join(f"{value:.9g}" for value in point)


def check_point(point: Vector, scenario: Scenario) -> None:
    """Refuse a point that no flight can pass. Raises InputError with what the point must be."""
    given = "X Y Z = " + " ".join(f"{value:g}" for value in point)
    if not all(map(isfinite, point)):
        raise InputError(f"{given}: should be three finite numbers, in m")
    if not scenario.pipe.is_open and not scenario.pipe.contains(point):
        nearest, away = find_nearest_inside(np.array(point), scenario.pipe.layout)
        inside = " ".join(f"{value:.4g}" for value in nearest)
        if (segment := scenario.pipe.straight) is not None:
            pipe = f"from {list(segment.start)} to {list(segment.end)} with radius {segment.radius:g} m"
        else:
            pipe = f"whose parts are {', '.join(placed.name for placed in scenario.pipe.layout.parts)}"
        raise InputError(
            f"{given} lies outside the pipe, {pipe}; it is {away:.3g} m away, and the nearest point inside is {inside}"
        )
