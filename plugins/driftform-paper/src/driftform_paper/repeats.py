"""The paper's experiment: its search repeated over seeds, compared with random search of the same budget."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from driftform import Pipeline, Run
from driftform.types import FloatArray, Genome, Trajectory
from driftform.water import Scenario

STRATEGIES = ("paper", "random")
"""The paper's search, and random search."""

PER_TARGET = 50
"""Flights for each target in a repeat: five generations of ten."""

GENERATION = 10


@dataclass(frozen=True, eq=False)
class Search:
    """What the repeats of one strategy came to: the ``fitness`` (%) of each flight of a target's own budget.

    That is (repeats, targets, flights); ``shared``, (repeats, targets), is the best over all flights of a repeat, also those of
    other targets. ``best`` has the genome of the best flight for each target over all repeats, the repeat's seed and the
    evaluation; ``failed`` is the number of flights that failed.
    """

    fitness: FloatArray
    best: tuple[tuple[Genome, int, int], ...]
    shared: FloatArray
    failed: int

    @property
    def error(self) -> FloatArray:
        """Error (%) at the end of each target's budget, (repeats, targets)."""
        return np.asarray(100 - self.fitness.max(axis=2))


def read_results(runs: Sequence[tuple[int, Path]]) -> Search:
    """Read what the repeats of a strategy came to; ``runs`` are seeds and directories.

    A flight counts for the target that its population worked for; where a strategy has no populations, as many
    flights as one would have had, one target after the other.
    """
    rows, shared, failed = [], [], 0
    best: dict[int, tuple[float, Genome, int, int]] = {}
    for seed, directory in runs:
        run = Run.open(directory)
        with run.read() as store:
            targets = run.study.scenario.target_names
            summaries = list(store.read_summaries(targets))
            failed += store.count_failed()
            shared.append(np.array([summary.fitness for summary in summaries]).max(axis=0))
            row = []
            for number, target in enumerate(targets):
                own = [summary for summary in summaries if summary.population == target]
                own = (own or summaries[number * PER_TARGET :])[:PER_TARGET]
                fitness = np.array([summary.fitness[number] for summary in own])
                row.append(fitness)
                top = int(np.argmax(fitness))
                if number not in best or fitness[top] > best[number][0]:
                    genome = store.read_record(own[top].index, targets).candidate.genome
                    best[number] = (float(fitness[top]), genome, seed, own[top].index)
        rows.append(row)
    ordered = tuple(best[number][1:] for number in sorted(best))
    return Search(np.array(rows), ordered, np.array(shared), failed)


@dataclass(frozen=True, eq=False)
class RepeatedFlights:
    """The best agents, flown again and again, one of them for each target.

    ``flights`` of each target, and the fitness (%) of all for that target, NaN for a flight that failed, (targets, repeats).
    """

    flights: tuple[tuple[Trajectory, ...], ...]
    fitness: FloatArray

    @property
    def deviation(self) -> FloatArray:
        """Standard deviation of the fitness of sound flights, %, (targets,): exactly zero where all flights are the same."""
        return np.array([(row - row[0]).std() if len(row) else np.nan for row in self._sound])

    @property
    def error(self) -> FloatArray:
        """Mean error of sound flights, %, (targets,); NaN without any."""
        return np.array([100 - row.mean() if len(row) else np.nan for row in self._sound])

    @property
    def _sound(self) -> list[FloatArray]:
        return [row[~np.isnan(row)] for row in self.fitness]

    @property
    def failed(self) -> list[int]:
        """Number of flights that failed, of each target."""
        return [int(np.isnan(row).sum()) for row in self.fitness]


def repeat_flights(pipeline: Pipeline, genomes: Sequence[Genome], scenarios: Sequence[Scenario]) -> RepeatedFlights:
    """Fly the best agent of each target once through each of ``scenarios``."""
    flights, fitness = [], []
    for number, genome in enumerate(genomes):
        agent = pipeline.make_agent(genome)
        flown = pipeline.fly([agent] * len(scenarios), scenarios)
        flights.append(tuple(flown))
        scores = [
            np.nan if f.end.failed else float(pipeline.score(f, agent, s)[number])
            for f, s in zip(flown, scenarios, strict=True)
        ]
        fitness.append(scores)
    return RepeatedFlights(tuple(flights), np.array(fitness))


def add_turbulence(scenario: Scenario, seeds: Sequence[int]) -> list[Scenario]:
    """Return the scenario with the turbulent flow of the same bulk speed, with gusts of each seed."""
    changed = {**dict(scenario), "flow": {"kind": "turbulent", "speed": scenario.flow.speed}}
    turbulent = Scenario.model_validate(changed)
    return [turbulent.with_gusts(seed) for seed in seeds]
