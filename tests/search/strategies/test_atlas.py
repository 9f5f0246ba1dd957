"""Illumination: which parents it takes, what it remembers, and what it lights."""

from collections import Counter

import numpy as np
import pytest

from driftform.errors import InputError
from driftform.interfaces import SearchSpace
from driftform.options import Table
from driftform.runs.coverage import CoverageMap, PipeGrid
from driftform.search.strategies.atlas import AtlasOptions, AtlasStrategy, breeding_probabilities
from driftform.study import load_study
from driftform.testing import StrategyContract
from driftform.testing.letters import LENGTH, LetterGrammar
from driftform.types import End, Evaluation, Genome, Trajectory
from driftform.water import Pipe, Scenario, Segment

GRAMMAR = LetterGrammar(Table())
SCENARIO = Scenario(pipe=Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0),)))


class TestAtlas(StrategyContract):
    def plugin(self, space):
        return AtlasStrategy(AtlasOptions(random=20, batch=7), space)


class TestAtlasAsItComes(StrategyContract):
    def plugin(self, space):
        return AtlasStrategy(AtlasOptions(), space)


class TestAtlasOfLargeCells(StrategyContract):
    def plugin(self, space):
        return AtlasStrategy(AtlasOptions(cell=1.0, random=10, batch=30, novelty=0, crossover=1), space)


def space(seed: int = 0, scenario: Scenario = SCENARIO) -> SearchSpace:
    return SearchSpace(GRAMMAR, (), np.random.default_rng(seed), scenario)


def level(height: float, start: float = 0.0, end: float = 9.0) -> Trajectory:
    """A flight along the pipe."""
    t = np.linspace(0.0, 9.0, 19)
    position = np.column_stack([start + (end - start) * t / 9, np.zeros(19), np.full(19, height)])
    velocity = np.tile([(end - start) / 9, 0, 0, 0, 0, 0], (19, 1))
    return Trajectory(t, position, np.tile([1.0, 0, 0, 0], (19, 1)), velocity, End.OUTLET)


def rising(genome: Genome) -> Trajectory:
    """A flight that rises with each letter a, and sinks with each c: random genomes are most alike in the middle."""
    height = sum({"a": 1, "b": 0, "c": -1}[letter] for letter in genome.symbols) / LENGTH
    t = np.linspace(0.0, 9.0, 19)
    position = np.column_stack([t, np.zeros(19), height * t / 9.01])
    velocity = np.tile([1.0, 0, height / 9.01, 0, 0, 0], (19, 1))
    return Trajectory(t, position, np.tile([1.0, 0, 0, 0], (19, 1)), velocity, End.OUTLET)


def told(strategy: AtlasStrategy, flights, fitness: float = 0.0) -> list[Genome]:
    """Let the strategy begin with these flights; return the genomes that it had asked for."""
    genomes = [candidate.genome for candidate in strategy.ask(len(flights))]
    assert len(genomes) == len(flights)
    strategy.tell(
        0,
        [
            Evaluation(
                genome, np.full(1, fitness), trajectory, None if trajectory is not None else "it broke"
            )
            for genome, trajectory in zip(genomes, flights, strict=True)
        ],
    )
    return genomes


def test_cells_that_few_flights_cross_are_favoured_in_proportion():
    np.testing.assert_allclose(breeding_probabilities(np.array([1, 2, 4]), 1.0), np.array([4, 2, 1]) / 7)
    np.testing.assert_allclose(breeding_probabilities(np.array([1, 2, 4]), 2.0), np.array([16, 4, 1]) / 21)
    np.testing.assert_allclose(breeding_probabilities(np.array([1, 2, 4]), 0.0), [1 / 3] * 3)


def test_parents_are_the_closest_flights_of_cells_and_the_rarer_the_cell_the_oftener():
    strategy = AtlasStrategy(AtlasOptions(random=4, batch=8000, crossover=0), space())
    # The first is the closest in every cell, also in those that all three cross.
    told(strategy, [level(0.25), level(0.26, 0.9), level(0.27, 0.9), None])
    parents = Counter(candidate.parents for candidate in strategy.ask(8000))
    assert set(parents) == {(0,)}

    strategy = AtlasStrategy(AtlasOptions(random=4, batch=8000, crossover=0), space())
    told(strategy, [level(0.25), level(0.26), level(0.27), level(-0.35, 0.0, 4.495)])
    parents = Counter(candidate.parents for candidate in strategy.ask(8000))
    assert set(parents) == {(0,), (3,)}
    # 90 cells of three flights weigh as much as 30 of one; the other row has 45 cells of one flight.
    share = 45 / (45 + 30)
    assert abs(parents[3,] - 8000 * share) < 5 * np.sqrt(8000 * share * (1 - share))


def test_offspring_descend_from_their_parents_and_never_equal_them():
    strategy = AtlasStrategy(AtlasOptions(random=6, batch=500, crossover=0.5), space(1))
    first = told(strategy, [level(0.05 + 0.1 * i) for i in range(6)])
    kinds = Counter()
    for candidate in strategy.ask(500):
        of = [first[parent] for parent in candidate.parents]
        kinds[len(of)] += 1
        assert candidate.genome not in of
        assert candidate.generation == 1
    assert set(kinds) == {1, 2}
    assert abs(kinds[2] - 250) < 5 * np.sqrt(500 * 0.25)


def test_a_child_that_would_equal_a_parent_has_one_symbol_flipped():
    rng = np.random.default_rng(0)
    parent = GRAMMAR.random(rng)
    for _ in range(50):
        child = GRAMMAR.breed(parent, parent, rng, crossover=0.5, mutation_rate=0.0)[0]
        assert sum(a != b for a, b in zip(child.symbols, parent.symbols, strict=True)) == 1


def test_a_genome_without_symbols_is_bred_as_it_is():
    empty = Genome("none", ())
    assert GRAMMAR.breed(empty, empty, np.random.default_rng(0), crossover=0, mutation_rate=0.5) == (
        empty,
        False,
    )


def test_the_search_begins_with_as_many_random_genomes_as_asked_for():
    strategy = AtlasStrategy(AtlasOptions(random=25, batch=10), space())
    first, sizes = 0, []
    for _ in range(5):
        candidates = strategy.ask(1000)
        sizes.append((len(candidates), any(candidate.parents for candidate in candidates)))
        strategy.tell(first, [Evaluation(c.genome, np.zeros(1), rising(c.genome)) for c in candidates])
        first += len(candidates)
    assert sizes == [(10, False), (10, False), (5, False), (10, True), (10, True)]


def test_where_every_flight_failed_the_search_goes_on_with_random_genomes():
    strategy = AtlasStrategy(AtlasOptions(random=5, batch=10), space())
    told(strategy, [None] * 5)
    assert [candidate.parents for candidate in strategy.ask(100)] == [()] * 10


def test_a_failed_flight_is_no_parent_however_far_it_came():
    strategy = AtlasStrategy(AtlasOptions(random=2, batch=50), space())
    [good, bad] = (candidate.genome for candidate in strategy.ask(2))
    strategy.tell(
        0,
        [
            Evaluation(good, np.zeros(1), level(0.2)),
            Evaluation(bad, np.zeros(1), level(0.5), "not converged"),
        ],
    )
    assert {candidate.parents for candidate in strategy.ask(50)} <= {(0,), (0, 0)}


def test_targets_and_fitness_have_no_say():
    def asked(fitness: float) -> list[Genome]:
        strategy = AtlasStrategy(AtlasOptions(random=10, batch=10), space(5))
        told(strategy, [level(0.1 * i) for i in range(-4, 6)], fitness)
        return [candidate.genome for candidate in strategy.ask(10)]

    assert asked(0.0) == asked(99.0)


def test_no_more_genomes_are_remembered_than_there_are_cells():
    strategy = AtlasStrategy(AtlasOptions(cell=1.0, random=10, batch=100), space())
    first = 0
    while first < 2000:
        candidates = strategy.ask(100)
        strategy.tell(first, [Evaluation(c.genome, np.zeros(1), rising(c.genome)) for c in candidates])
        first += len(candidates)
    assert len(strategy._elites) <= PipeGrid.of_scenario(SCENARIO, 1.0).cell_count == 18


@pytest.mark.parametrize("seed", range(5))
def test_it_lights_more_of_the_pipe_than_as_many_random_genomes_do(seed):
    reach, first = CoverageMap(PipeGrid.of_scenario(SCENARIO)), 0
    strategy = AtlasStrategy(AtlasOptions(random=50, batch=25), space(seed))
    while first < 600:
        candidates = strategy.ask(600 - first)
        flights = [rising(candidate.genome) for candidate in candidates]
        for index, trajectory in enumerate(flights, first):
            reach.add(index, trajectory)
        strategy.tell(
            first, [Evaluation(c.genome, np.zeros(1), f) for c, f in zip(candidates, flights, strict=True)]
        )
        first += len(candidates)
    rng, by_chance = np.random.default_rng(seed), CoverageMap(PipeGrid.of_scenario(SCENARIO))
    for index in range(600):
        by_chance.add(index, rising(GRAMMAR.random(rng)))
    assert np.count_nonzero(reach.reached) > 1.1 * np.count_nonzero(by_chance.reached)


def test_open_water_is_refused_in_one_line():
    with pytest.raises(InputError, match="needs a pipe; this scenario is open water"):
        AtlasStrategy(AtlasOptions(), space(scenario=Scenario()))


def test_a_study_gives_its_strategy_the_scenario():
    study = load_study("paper", use={"strategy": "atlas"}, run={"seed": 0})
    assert study.make_strategy().space.scenario is study.scenario
