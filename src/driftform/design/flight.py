"""One flight of an agent: its trajectory, what it scores, and how a notebook shows it."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from driftform.errors import find_commonest
from driftform.figures.files import write_picture
from driftform.figures.flight import flight_svg
from driftform.figures.style import Page
from driftform.motion.path.targets import approach_targets, name_outlet
from driftform.runs.misses import Misses
from driftform.runs.table_files import FLIGHT_COLUMNS
from driftform.types import Agent, ByContent, End, FloatArray, Trajectory
from driftform.util.files import make_directory
from driftform.util.notebook import show_picture, show_table
from driftform.water import Scenario


@dataclass(frozen=True, eq=False)
class Flight(ByContent):
    """One flight of an agent through its scenario.

    Attributes:
        name: of the agent.
        trajectory: time (s), position (m), attitude and velocity, sample by sample.
        scenario: what it flew through.
        agent: what flew.
        fitness: for each target, %; 100 is a hit.
    """

    name: str
    trajectory: Trajectory
    scenario: Scenario
    agent: Agent
    fitness: Mapping[str, float]

    @property
    def end(self) -> End:
        """Why the flight ended."""
        return self.trajectory.end

    @cached_property
    def outlet(self) -> str | None:
        """Name of the outlet by which it left the pipe; ``None`` if it did not."""
        return name_outlet(self.trajectory, self.scenario)

    @property
    def duration(self) -> float:
        """From the release to the end, s."""
        return float(self.trajectory.t[-1])

    @cached_property
    def approaches(self) -> dict[str, tuple[float, float]]:
        """Distance (m, through the water) and time (s) of the closest approach to each target."""
        distance, t = approach_targets(self.trajectory, self.scenario)
        rows = zip(distance.tolist(), t.tolist(), strict=True)
        return dict(zip(self.scenario.target_names, rows, strict=True))

    @cached_property
    def closest(self) -> dict[str, float]:
        """Distance of the closest approach to each target, m."""
        return {target: distance for target, (distance, _) in self.approaches.items()}

    @property
    def closest_time(self) -> float:
        """When the agent is closest to any target, s; half of the flight if there are none."""
        return min(self.approaches.values())[1] if self.approaches else self.duration / 2

    def columns(self) -> dict[str, FloatArray]:
        """The flight as columns, for ``pandas.DataFrame(flight.columns())``: those of ``trajectory.csv``."""
        t = self.trajectory
        parts = (t.t, *t.position.T, *t.quaternion.T, *t.velocity.T)
        return dict(zip(FLIGHT_COLUMNS, parts, strict=True))

    def draw(self, path: str | os.PathLike[str], width_mm: float | None = None) -> tuple[Path, ...]:
        """Write the picture of the flight as SVG, and return the paths of its files.

        With ``width_mm`` it is a figure for a paper, without a title, and with the extra ``pdf`` a PDF is written too.
        """
        page = Page.find(width_mm)
        make_directory(Path(path).parent, "path")
        drawn = flight_svg(self.trajectory, self.scenario, self.name, self.agent.body, page)
        return write_picture(Path(path), drawn, page, png=False)

    def __repr__(self) -> str:
        return f"<Flight of {self.name}: {self.duration:.2f} s to the {self.end}>"

    def _repr_svg_(self) -> str:
        return flight_svg(self.trajectory, self.scenario, self.name, self.agent.body)

    def _repr_html_(self) -> str:
        rows = ((t, f"{self.fitness[t]:.2f}", f"{1000 * self.closest[t]:.1f}") for t in self.fitness)
        return show_picture(self._repr_svg_(), repr(self)) + show_table(("target", "fitness %", "closest mm"), rows)


@dataclass(frozen=True, eq=False)
class DisturbedFlights(Misses):
    """How far an agent's disturbed flights miss, and where they end.

    Attributes:
        outlets: name of the outlet by which each flight left the pipe; ``None`` if it did not, or failed.
        failures: why each flight failed, ``None`` for a sound one.
    """

    outlets: Sequence[str | None] = ()
    failures: Sequence[str | None] = ()

    def describe_failures(self) -> str:
        """Return the commonest reason of the failures, ``""`` without any."""
        return find_commonest(reason for reason in self.failures if reason is not None)[0]

    def outlet_shares(self, scenario: Scenario) -> dict[str, float]:
        """Return the share of all flights that left by each outlet, 0 to 1; empty in open water."""
        return {
            outlet.name: sum(name == outlet.name for name in self.outlets) / max(1, self.count)
            for outlet in scenario.pipe.layout.outlets
        }
