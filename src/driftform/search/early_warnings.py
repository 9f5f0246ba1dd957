"""Early warnings: what the first flights of a run show of its study, such as agents that come to rest."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from driftform.study.advice import list_targets
from driftform.types import End, Evaluation, FloatArray, Trajectory
from driftform.water import Scenario
from driftform.water.misfit import show_length

FIRST = 20
"""Number of flights that are looked at: the first of a run, of random agents with most strategies."""

MAX_AT_REST = 0.9
"""Share of the flights that may last to the horizon; with so many, the study is at fault.

If half of all agents arrived, more than 17 of 20 would fail to in one study of 5000.
"""


@dataclass
class EarlyWarnings:
    """Collects the first flights of a run, and warns once."""

    scenario: Scenario
    _flights: dict[int, Trajectory | None] = field(default_factory=dict)

    def add(self, index: int, evaluation: Evaluation) -> list[str]:
        """Take the outcome of an evaluation; return the warnings when the last of the first ones has arrived."""
        if index >= FIRST or index in self._flights:
            return []
        self._flights[index] = None if evaluation.failure else evaluation.trajectory
        flights = [flight for flight in self._flights.values() if flight is not None]
        if len(self._flights) < FIRST or len(flights) < FIRST // 2:
            return []
        return [*_describe_ends(flights, self.scenario), *_describe_targets(flights, self.scenario)]


def _describe_ends(flights: list[Trajectory], scenario: Scenario) -> Iterator[str]:
    held = [flight for flight in flights if flight.end == End.HORIZON]
    if len(held) < MAX_AT_REST * len(flights):
        return
    distances = [float(np.linalg.norm(flight.position[-1] - flight.position[0])) for flight in held]
    yield (
        f"{len(held)} of the first {len(flights)} flights last to flight.horizon = {scenario.flight.horizon:g} s, and end "
        f"{show_length(min(distances))} to {show_length(max(distances))} from the release (median {show_length(float(np.median(distances)))}): "
        "agents come to rest on the wall, or need longer; raise flow.speed or flight.horizon, or evolve agents nearer to the density of the water "
        "(builder, grammar)"
    )


def _describe_targets(flights: list[Trajectory], scenario: Scenario) -> Iterator[str]:
    missed = {
        name: min(float(np.linalg.norm(flight.position[-1] - point)) for flight in flights)
        for name, point in scenario.target_points().items()
        if not any(_passes(flight, np.array(point), scenario) for flight in flights)
    }
    if missed:
        yield (
            f"none of the first {len(flights)} flights passes {list_targets(missed)}: the nearest ends "
            f"{show_length(min(missed.values()))} before; is the target downstream of the release, in a part that has flow?"
        )


def _passes(flight: Trajectory, target: FloatArray, scenario: Scenario) -> bool:
    """Return whether a flight is nearest to a target before its end, or leaves the pipe within a radius of it."""
    distances = np.linalg.norm(flight.position - target, axis=1)
    leaves = flight.end == End.OUTLET and distances[-1] <= scenario.pipe.layout.inlet.radius
    return bool(leaves or np.argmin(distances) < len(distances) - 1)
