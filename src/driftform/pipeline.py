"""Genome -> morphology -> body -> coefficients -> trajectory -> fitness: the whole program on one page."""

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from driftform.agent import mass_properties, measure_evaluation, solid_of_revolution
from driftform.errors import WorkFailedError
from driftform.interfaces import Fitness, Grammar, Hydrodynamics, PhenotypeBuilder, Simulator
from driftform.plugins import faults
from driftform.plugins.seams import (
    require_body,
    require_coefficients,
    require_flights,
    require_measures,
    require_morphology,
    require_scores,
)
from driftform.types import Agent, Body, ByContent, End, Evaluation, FloatArray, Genome, Morphology, Trajectory
from driftform.water import Scenario
from driftform.water.disturbances import (
    Condition,
    Specimen,
    disturb_calibration,
    disturb_fluid,
    disturb_scenario,
    stop_after_targets,
)
from driftform.water.misfit import ease_release, find_misfit, find_violations
from driftform.water.prints import disturb_body

MARGIN = 0.2
"""Fitness (%) below its threshold down to which an unchecked flight still matters, because its fitness may be too low.

Of 2000 random agents in `paper`, 2.9 % have an unchecked flight whose fitness is too low by more than that for any target;
of 252 agents of a search that matter, none is missed.
"""

KEPT_BODIES = 128
"""Bodies that are kept for flights under other conditions."""


def require_success(trajectory: Trajectory, name: str) -> None:
    """Raise WorkFailedError if a flight of the agent ``name`` failed."""
    if trajectory.failure is not None:
        raise WorkFailedError(f"{name}: {trajectory.failure}")


@dataclass(frozen=True, eq=False)
class ScoredFlight:
    """A trajectory, and the fitness (%) of its flight for each target, (targets,)."""

    trajectory: Trajectory
    fitness: FloatArray


@dataclass(frozen=True, eq=False)
class Pipeline(ByContent):
    """One plugin for each step, and the scenario of the flights.

    Attributes:
        scenario: environment of the flights.
        grammar: genome -> morphology.
        builder: morphology -> body.
        hydrodynamics: body -> coefficients.
        simulator: agent, scenario -> trajectory.
        fitness: trajectory -> fitness for each target.
    """

    scenario: Scenario
    grammar: Grammar[Any]
    builder: PhenotypeBuilder[Any]
    hydrodynamics: Hydrodynamics[Any]
    simulator: Simulator[Any]
    fitness: Fitness[Any]

    def express(self, genome: Genome) -> Morphology:
        """Genome -> morphology, with the genome's tuning."""
        morphology = require_morphology(self.grammar.express(genome), self.grammar)
        return replace(morphology, tuning=genome.tuning) if genome.tuning else morphology

    def realise(
        self, morphology: Morphology, genome: Genome | None = None, condition: Condition | None = None
    ) -> Agent:
        """Morphology -> agent, as calibrated, and as printed under a disturbed condition if one is given."""
        return self._complete(self.build(morphology), morphology, genome, condition)

    def make_agent(self, genome: Genome, condition: Condition | None = None) -> Agent:
        """Genome -> agent."""
        morphology, body = self._develop(genome)
        return self._complete(body, morphology, genome, condition)

    @cached_property
    def _develop(self) -> Callable[[Genome], tuple[Morphology, Body]]:
        """Genome -> morphology and body; what disturbed flights ask for again and again is kept."""

        def develop(genome: Genome) -> tuple[Morphology, Body]:
            morphology = self.express(genome)
            return morphology, self.build(morphology)

        return lru_cache(maxsize=KEPT_BODIES)(develop)

    def __getstate__(self) -> dict[str, Any]:
        """Return what another process needs; it keeps bodies of its own."""
        return {name: value for name, value in vars(self).items() if name != "_develop"}

    def build(self, morphology: Morphology) -> Body:
        """Morphology -> body."""
        return require_body(self.builder.build(morphology), self.builder)

    def _complete(
        self, body: Body, morphology: Morphology, genome: Genome | None, condition: Condition | None
    ) -> Agent:
        scenario, options = self.scenario, self.hydrodynamics.options
        fluid, calibration = scenario.fluid, scenario.calibration
        if condition is not None and condition.specimen is Specimen.IDLE:
            from driftform.motion.forces.spheres import make_sphere

            volume = solid_of_revolution(body.outer).volume
            return make_sphere((6 * volume / np.pi) ** (1 / 3), disturb_fluid(condition, fluid))
        if condition is not None:
            calibration = disturb_calibration(condition, calibration)
        factors = calibration.factors
        body = factors.scale_body(body)
        mass = mass_properties(body)
        if condition is not None:
            # The water flows around it as around the design: a tenth of a millimetre changes its weight, and no coefficient.
            mass, fluid = mass_properties(disturb_body(condition, body, fluid)), disturb_fluid(condition, fluid)
        found = self.hydrodynamics.coefficients(body, fluid)
        coefficients = require_coefficients(found, body, self.hydrodynamics)
        if options.drag == "strips":
            from driftform.motion.forces.body_drag import estimate_drag, wake_factor

            factor = wake_factor(coefficients, fluid.density * mass.volume)
            drag = estimate_drag(body, fluid.viscosity, factor, options.drag_without)
            coefficients = replace(coefficients, drag=drag)
        coefficients = factors.scale_coefficients(coefficients)
        return Agent(body, scenario.release.load(mass), coefficients, morphology, genome)

    def try_build(self, genome: Genome) -> Body | str:
        """Return the body of a genome, or why it cannot be built or released, in one line."""
        try:
            body = self.build(self.express(genome))
        except Exception as error:
            return faults.describe_fault(error)
        return find_misfit(body, self.scenario) or body

    def fly(self, agents: Sequence[Agent], scenarios: Sequence[Scenario] | None = None) -> list[Trajectory]:
        """Agents -> trajectories, each in the pipeline's scenario or in its own of ``scenarios``."""
        flights = self.simulator.simulate_batch(agents, scenarios or [self.scenario] * len(agents))
        return require_flights(flights, len(agents), self.simulator)

    def fly_named(self, agents: Sequence[Agent], name: str) -> list[Trajectory]:
        """Agents -> their flights; ``name`` says in errors whose they are.

        Raises:
            WorkFailedError: if one of them does not fit into the pipe, or the simulator cannot fly it. A flight that
                ended by a failure is returned.
        """
        for agent in agents:
            if (misfit := find_misfit(agent.body, self.scenario)) is not None:
                raise WorkFailedError(f"{name}: {misfit}")
        try:
            return self.fly(agents)
        except (ArithmeticError, RuntimeError) as error:
            raise WorkFailedError(f"{name}: cannot be flown: {faults.describe_fault(error)}") from None

    def score(self, trajectory: Trajectory, agent: Agent, scenario: Scenario | None = None) -> FloatArray:
        """Trajectory -> fitness (%) for each target, (targets,), in the pipeline's scenario or in another."""
        scenario = scenario or self.scenario
        scores = self.fitness.score(trajectory, scenario, agent)
        return require_scores(scores, len(scenario.targets), self.fitness)

    def simulate(self, agents: Sequence[Agent], name: str) -> list[ScoredFlight]:
        """Agents -> their flights with what they score; ``name`` says in errors whose they are.

        Raises WorkFailedError if one of them cannot be flown, or its flight fails.
        """
        trajectories = self.fly_named(agents, name)
        for trajectory in trajectories:
            require_success(trajectory, name)
        return [
            ScoredFlight(trajectory, self.score(trajectory, agent))
            for trajectory, agent in zip(trajectories, agents, strict=True)
        ]

    def evaluate(
        self,
        genomes: Sequence[Genome],
        seeds: Sequence[int | None] | None = None,
        conditions: Sequence[Condition | None] | None = None,
        thresholds: Sequence[tuple[float, ...] | None] | None = None,
        wanted: Sequence[tuple[bool, ...] | None] | None = None,
    ) -> list[Evaluation]:
        """Genomes -> evaluations, in their order; one flight scores every target.

        An error in the evaluation of a genome becomes the failure of that evaluation, and does not affect the others.
        A flight with a threshold may stay unchecked (its ``error`` is ``None``) if its fitness is more than
        :data:`MARGIN` below that for every target. All other
        flights are checked.

        Args:
            genomes: the genomes to evaluate.
            seeds: seed of the gusts for each genome, ``None`` for that of the scenario.
            conditions: disturbed conditions of each genome's flight, ``None`` for undisturbed.
            thresholds: for each genome, the fitness for each target (%) that it must exceed to matter; ``None`` if
                every fitness matters.
            wanted: for each genome, which targets its disturbed flight is for, (targets,), ``None`` for all. It may end behind
                the last of them (:func:`driftform.water.disturbances.stop_after_targets`), and what it scores for others means nothing.
        """
        started = time.perf_counter()
        targets = len(self.scenario.targets)
        conditions, wanted = conditions or [None] * len(genomes), wanted or [None] * len(genomes)
        scenarios = [self.scenario.with_gusts(seed) for seed in seeds or [None] * len(genomes)]
        scenarios = [
            usual if condition is None else disturb_scenario(condition, usual)
            for usual, condition in zip(scenarios, conditions, strict=True)
        ]
        outcomes: dict[int, Evaluation] = {}
        agents: dict[int, Agent] = {}
        violations: dict[int, dict[str, float]] = {}
        for index, genome in enumerate(genomes):
            try:
                agent = self.make_agent(genome, conditions[index])
            except faults.CAUGHT as error:
                outcomes[index] = Evaluation.failed(genome, targets, faults.describe_fault(error))
                violations[index] = getattr(error, "violations", {})
                continue
            if conditions[index] is not None:
                scenarios[index] = ease_release(agent.body, self.scenario, scenarios[index])
                if (flown_for := wanted[index]) is not None and self.fitness.judges_passing:
                    scenarios[index] = stop_after_targets(scenarios[index], flown_for)
            else:
                violations[index] = find_violations(agent.body, self.scenario)
            misfit = find_misfit(agent.body, scenarios[index])
            if misfit is None:
                agents[index] = agent
            else:
                outcomes[index] = Evaluation.failed(genome, targets, misfit)
        bounds, screened = list(thresholds or [None] * len(genomes)), dict[Agent, ScoredFlight]()
        flights = self._fly_each(
            list(agents.values()), [scenarios[index] for index in agents], [bounds[index] for index in agents], screened
        )
        for index, flight in zip(agents, flights, strict=True):
            agent = agents[index]
            disturbed = conditions[index] is not None
            outcomes[index] = self._score(genomes[index], agent, flight, screened.get(agent), disturbed)
        share = (time.perf_counter() - started) / max(1, len(genomes))
        return [
            replace(found, seconds=share, violations={**violations.get(index, {}), **found.violations})
            for index, found in sorted(outcomes.items())
        ]

    def _fly_each(
        self,
        agents: Sequence[Agent],
        scenarios: Sequence[Scenario],
        thresholds: Sequence[tuple[float, ...] | None],
        screened: dict[Agent, ScoredFlight],
    ) -> list[Trajectory | str]:
        """Return a flight, or the reason why it failed, for each agent; keep what the screening of unchecked flights scored."""
        if not agents:
            return []
        try:
            return list(self._fly_or_screen(agents, scenarios, thresholds, screened))
        except faults.CAUGHT as error:
            if len(agents) == 1:
                return [faults.describe_fault(error)]
            return [
                flight
                for agent, scenario, threshold in zip(agents, scenarios, thresholds, strict=True)
                for flight in self._fly_each([agent], [scenario], [threshold], screened)
            ]

    def _fly_or_screen(
        self,
        agents: Sequence[Agent],
        scenarios: Sequence[Scenario],
        thresholds: Sequence[tuple[float, ...] | None],
        screened: dict[Agent, ScoredFlight],
    ) -> list[Trajectory]:
        if all(threshold is None for threshold in thresholds):
            return self.fly(agents, scenarios)

        def matters(index: int, trajectory: Trajectory) -> bool:
            agent, threshold = agents[index], thresholds[index]
            if threshold is None or trajectory.failure is not None:
                return True
            try:
                fitness = self.score(trajectory, agent)
            except faults.CAUGHT:
                # The same error in the score of the checked flight is the failure of the evaluation.
                return True
            screened[agent] = ScoredFlight(trajectory, fitness)
            return not np.all(fitness <= np.array(threshold) - MARGIN)

        flights = self.simulator.screen_batch(agents, scenarios, matters)
        return require_flights(flights, len(agents), self.simulator, "screen_batch")

    def _score(
        self, genome: Genome, agent: Agent, trajectory: Trajectory | str, screened: ScoredFlight | None, disturbed: bool
    ) -> Evaluation:
        targets = len(self.scenario.targets)
        if isinstance(trajectory, str):
            return Evaluation.failed(genome, targets, trajectory)
        if trajectory.failure is not None:
            failed = Evaluation.failed(genome, targets, trajectory.failure, trajectory)
            if disturbed and trajectory.end is End.NOT_CONVERGED:
                # Where it passed a target before, its fitness there counts among those of the other conditions.
                with suppress(Exception, SystemExit):
                    return replace(failed, fitness=self.score(trajectory, agent))
            return failed
        try:
            is_scored = screened is not None and screened.trajectory is trajectory
            fitness = screened.fitness if screened is not None and is_scored else self.score(trajectory, agent)
            if disturbed:
                return Evaluation(genome, fitness, trajectory)
            found = require_measures(self.fitness.find_measures(trajectory, self.scenario, agent), self.fitness)
            missed = {name: found.pop(name) for name, one in self.fitness.measures.items() if one.is_violation}
            line = self.scenario.pipe.straight
            ends = None if line is None else (line.start, line.end)
            measures = measure_evaluation(agent, trajectory, self.scenario.fluid.density, ends) | found
            return Evaluation(genome, fitness, trajectory, measures=measures, violations=missed)
        except faults.CAUGHT as error:
            return Evaluation.failed(genome, targets, faults.describe_fault(error))
