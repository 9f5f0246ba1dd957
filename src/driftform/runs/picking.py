"""Pick the agent of a run whose flight passes closest to a point, also to a point that was not a target."""

from math import isfinite
from pathlib import Path

from driftform.errors import InputError
from driftform.runs.agent_file import StoredAgent, write_agent
from driftform.runs.run import Run
from driftform.scenario import Scenario, Vector
from driftform.trajectory.coverage import find_closest_pass
from driftform.util.files import make_directory
from driftform.util.progress import track_progress


def pick_agent(run: Run, point: Vector) -> StoredAgent:
    """Return the agent whose stored flight passes closest to a point of the world (m).

    Its ``result`` holds the point, the distance (m), when it passes (``t``, s) and its evaluation.

    Raises
    ------
    InputError
        if no flight can pass the point, or every evaluation has failed so far.
    """
    check_point(point, run.study.scenario)
    with run.read() as store:
        found = find_closest_pass(
            track_progress(store.read_trajectories(), store.count_sound(), "flights"), point
        )
        if found is None:
            raise run.refuse_unsound()
        genome = store.read_record(found.evaluation, run.study.scenario.target_names).evaluation.genome
    result = {
        "point": list(point),
        "distance": found.distance,
        "t": found.t,
        "evaluation": found.evaluation,
    }
    name = f"{run.name}-{name_point(point)}"
    return StoredAgent(name, genome, run.study.environment(found.evaluation), result)


def write_pick(run: Run, point: Vector, folder: Path | None = None) -> tuple[StoredAgent, Path]:
    """Pick an agent, and write it as ``agent.json`` into a folder, by default ``picks/X_Y_Z`` of the run."""
    stored = pick_agent(run, point)
    path = make_directory(folder or run.path / "picks" / name_point(point)) / "agent.json"
    write_agent(path, stored)
    return stored, path


def name_point(point: Vector) -> str:
    """Return a point as a name of a folder.

    >>> name_point((4.5, 0.0, -0.25))
    '4.5_0_-0.25'
    """
    return "_".join(f"{value:.9g}" for value in point)


def check_point(point: Vector, scenario: Scenario) -> None:
    """Refuse a point that no flight can pass.

    Raises
    ------
    InputError
        with what the point must be.
    """
    given = "X Y Z = " + " ".join(f"{value:g}" for value in point)
    if not all(map(isfinite, point)):
        raise InputError(f"{given}: should be three finite numbers, in m")
    if scenario.pipe.segments and not scenario.pipe.contains(point):
        pipes = ", then ".join(
            f"from {list(s.start)} to {list(s.end)} with radius {s.radius:g} m"
            for s in scenario.pipe.segments
        )
        raise InputError(f"{given} lies outside the pipe, which leads {pipes}")
