"""Agents from which a fleet is chosen, such as those of a run whose flights differ most."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from driftform.errors import InputError
from driftform.types import FloatArray
from driftform_networks.flights.bodies import SCENARIO, Traveller, open_traveller, trim_design
from driftform_networks.hydraulics.network import IntArray

if TYPE_CHECKING:
    from driftform import Design

BUOYANCIES = (0.0, 0.001, -0.001)
"""Net buoyancies to which each agent is trimmed by default, N: a tenth of a gram lighter or heavier than water."""


def collect_candidates(
    agents: Sequence[str],
    run: Path | None,
    count: int,
    buoyancies: Sequence[float] | None,
    scenario: str | None = None,
    settings: Sequence[str] = (),
) -> list[Traveller]:
    """Return the bodies from which a fleet is chosen.

    Args:
        agents: AGENT as every command takes it, or spheres; one of 60 mm if there is no run either.
        run: run from which ``count`` agents are taken besides.
        buoyancies: net buoyancies to which each is trimmed, N; ``None`` for that of their designs.
        scenario, settings: as for :func:`driftform_networks.flights.bodies.open_traveller`.

    Raises InputError if there is no such agent or run, or none of them can be trimmed.
    """
    environment = scenario or str(SCENARIO)
    designs: list[Design | str] = list(agents or ([] if run else ["sphere:60mm"]))
    if run is not None:
        designs += pick_agents(run, count, environment, settings)
    found, refused = [], []
    for design in designs:
        for buoyancy in [None] if buoyancies is None else buoyancies:
            try:
                if isinstance(design, str):
                    found.append(open_traveller(design, scenario, settings, buoyancy))
                else:
                    found.append(trim_design(design, buoyancy))
            except InputError as error:
                # Of many agents, those that are too heavy are left out; one that is named must be sound.
                if isinstance(design, str):
                    raise
                refused.append(error)
    if not found:
        raise refused[0]
    return found


def pick_agents(run: Path, count: int, environment: str, settings: Sequence[str]) -> "list[Design]":
    """Return the agents of a run whose flights differ most: the best for the first target, and then those farthest off.

    Flights differ by their fitness for the targets of the run; each agent that is added has the greatest distance from
    the nearest of those before it (Gonzalez 1985, doi:10.1016/0304-3975(85)90224-5).

    Raises InputError if it is not a run, or all its evaluations failed.
    """
    from driftform import Design, Run, StoredAgent

    opened = Run.open(run)
    targets = opened.study.scenario.target_names
    with opened.read() as store:
        sound = [summary for summary in store.read_summaries(targets) if summary.failure is None]
        if not sound:
            raise opened.refuse_unsound()
        rows = spread_rows(np.array([summary.fitness for summary in sound]), count)
        indices = [sound[row].index for row in rows.tolist()]
        genomes = [store.read_record(index, targets).candidate.genome for index in indices]
    made = opened.study.environment()
    return [
        Design.build(StoredAgent(f"{opened.name}-{index}", genome, made, {}), f"{run}", environment, settings)
        for index, genome in zip(indices, genomes, strict=True)
    ]


def spread_rows(points: FloatArray, count: int) -> IntArray:
    """Return rows of points (n, m) that are far from each other, at most ``count`` of them, no two of them equal."""
    chosen = [int(np.argmax(points[:, 0]))]
    nearest = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < count and nearest.max() > 0:
        chosen.append(int(np.argmax(nearest)))
        nearest = np.minimum(nearest, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.array(chosen, np.int64)


def save_agents(travellers: Sequence[Traveller], folder: Path) -> list[Path]:
    """Write the agent.json of each body that has one, from which ``driftform export`` makes printable files."""
    from driftform.util import files

    written = []
    for traveller in travellers:
        if (design := traveller.design) is not None:
            path = folder / f"{traveller.name}.json"
            files.make_directory(folder, "--agents")
            replace(design.stored, environment=design.study.environment()).write(path)
            written.append(path)
    return written
