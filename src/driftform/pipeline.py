"""Genome -> morphology -> body -> coefficients -> trajectory -> fitness: the whole program on one page."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from driftform.errors import WorkFailedError, describe_error
from driftform.faults import describe_fault, require, require_flights
from driftform.geometry import mass_properties
from driftform.interfaces import Fitness, Grammar, Hydrodynamics, PhenotypeBuilder, Simulator
from driftform.scenario import Scenario
from driftform.scenario.disturbances import Condition, disturb_body, disturb_scenario, draw_conditions
from driftform.types import (
    Agent,
    Body,
    Coefficients,
    Evaluation,
    FloatArray,
    Genome,
    Morphology,
    Trajectory,
)


@dataclass(frozen=True, eq=False)
class ScoredFlight:
    """A trajectory, and the fitness (%) of its flight for each target, (targets,)."""

    trajectory: Trajectory
    fitness: FloatArray


@dataclass(frozen=True, eq=False)
class Pipeline:
    """One plugin for each step, the scenario of the flights, and the seed of their randomness.

    Attributes
    ----------
    scenario
        environment of the flights.
    grammar
        genome -> morphology.
    builder
        morphology -> body.
    hydrodynamics
        body -> coefficients.
    simulator
        agent, scenario -> trajectory.
    fitness
        trajectory -> fitness for each target.
    seed
        seed of the disturbed conditions.
    """

    scenario: Scenario
    grammar: Grammar[Any]
    builder: PhenotypeBuilder[Any]
    hydrodynamics: Hydrodynamics[Any]
    simulator: Simulator[Any]
    fitness: Fitness[Any]
    seed: int = 0

    def express(self, genome: Genome) -> Morphology:
        """Genome -> morphology."""
        return require(self.grammar.express(genome), Morphology, self.grammar, "express")

    def realise(
        self, morphology: Morphology, genome: Genome | None = None, condition: Condition | None = None
    ) -> Agent:
        """Morphology -> agent, as printed under a disturbed condition if one is given."""
        body, scenario = require(self.builder.build(morphology), Body, self.builder, "build"), self.scenario
        if condition is not None:
            body, scenario = disturb_body(condition, body), disturb_scenario(condition, scenario)
        found = self.hydrodynamics.coefficients(body, scenario.fluid)
        coefficients = require(found, Coefficients, self.hydrodynamics, "coefficients")
        if self.hydrodynamics.options.drag == "strips":
            from driftform.hydrodynamics.drag import estimate_drag

            coefficients = replace(coefficients, drag=estimate_drag(body, scenario.fluid.viscosity))
        return Agent(body, mass_properties(body), coefficients, morphology, genome)

    def make_agent(self, genome: Genome, condition: Condition | None = None) -> Agent:
        """Genome -> agent."""
        return self.realise(self.express(genome), genome, condition)

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """The disturbed conditions of the finalists' flights."""
        return draw_conditions(self.scenario.robustness, self.seed)

    def fly(self, agents: Sequence[Agent], scenarios: Sequence[Scenario] | None = None) -> list[Trajectory]:
        """Agents -> trajectories, each in the pipeline's scenario or in its own of ``scenarios``."""
        flights = self.simulator.simulate_batch(agents, scenarios or [self.scenario] * len(agents))
        return require_flights(flights, len(agents), self.simulator)

    def fly_named(self, agents: Sequence[Agent], name: str) -> list[Trajectory]:
        """Agents -> their flights; ``name`` says in errors whose they are.

        Raises
        ------
        WorkFailedError
            if the simulator cannot fly one of them. A flight that ended by a failure is returned.
        """
        try:
            return self.fly(agents)
        except (ArithmeticError, RuntimeError) as error:
            raise WorkFailedError(f"{name}: cannot be flown: {describe_error(error)}") from None

    def simulate(self, agents: Sequence[Agent], name: str) -> list[ScoredFlight]:
        """Agents -> their flights with what they score; ``name`` says in errors whose they are.

        Raises
        ------
        WorkFailedError
            if one of them cannot be flown, or its flight fails.
        """
        trajectories = self.fly_named(agents, name)
        for trajectory in trajectories:
            trajectory.require_success(name)
        return [ScoredFlight(t, self.fitness.score(t, self.scenario)) for t in trajectories]

    def evaluate(
        self,
        genomes: Sequence[Genome],
        seeds: Sequence[int | None] | None = None,
        disturbed: Sequence[int | None] | None = None,
    ) -> list[Evaluation]:
        """Genomes -> evaluations, in their order; one flight scores every target.

        An error in the evaluation of a genome becomes the failure of that evaluation, and does not affect the others.

        Parameters
        ----------
        genomes
            the genomes to evaluate.
        seeds
            seed of the gusts for each genome, ``None`` for that of the scenario.
        disturbed
            index into :attr:`conditions` for each genome, ``None`` for undisturbed.
        """
        started = time.perf_counter()
        targets = len(self.scenario.targets)
        under = [None if c is None else self.conditions[c] for c in disturbed or [None] * len(genomes)]
        scenarios = [self.scenario.with_gusts(seed) for seed in seeds or [None] * len(genomes)]
        scenarios = [
            usual if condition is None else disturb_scenario(condition, usual)
            for usual, condition in zip(scenarios, under, strict=True)
        ]
        outcomes: dict[int, Evaluation] = {}
        agents: dict[int, Agent] = {}
        for index, genome in enumerate(genomes):
            try:
                agents[index] = self.make_agent(genome, under[index])
            except (Exception, SystemExit) as error:
                outcomes[index] = Evaluation.failed(genome, targets, describe_fault(error))
        flights = self._fly_each(list(agents.values()), [scenarios[index] for index in agents])
        for index, trajectory in zip(agents, flights, strict=True):
            outcomes[index] = self._score(genomes[index], trajectory)
        share = (time.perf_counter() - started) / max(1, len(genomes))
        return [replace(outcomes[index], seconds=share) for index in range(len(genomes))]

    def _fly_each(self, agents: Sequence[Agent], scenarios: Sequence[Scenario]) -> list[Trajectory | str]:
        if not agents:
            return []
        try:
            return list(self.fly(agents, scenarios))
        except (Exception, SystemExit) as error:
            if len(agents) == 1:
                return [describe_fault(error)]
            return [
                flight
                for agent, scenario in zip(agents, scenarios, strict=True)
                for flight in self._fly_each([agent], [scenario])
            ]

    def _score(self, genome: Genome, trajectory: Trajectory | str) -> Evaluation:
        targets = len(self.scenario.targets)
        if isinstance(trajectory, str):
            return Evaluation.failed(genome, targets, trajectory)
        if trajectory.failure is not None:
            return Evaluation.failed(genome, targets, trajectory.failure, trajectory)
        try:
            return Evaluation(genome, self.fitness.score(trajectory, self.scenario), trajectory)
        except (Exception, SystemExit) as error:
            return Evaluation.failed(genome, targets, describe_fault(error))
