"""The paper's genetic algorithm."""

from collections import Counter

import numpy as np
import pytest

from driftform import Study, load_study
from driftform.interfaces import SearchSpace, Table
from driftform.motion.path.targets import approach_targets
from driftform.testing import StrategyContract
from driftform.testing.letters import LENGTH, LetterGrammar
from driftform.types import Evaluation
from driftform_paper.strategy import PaperOptions, PaperStrategy, roulette_probabilities

GRAMMAR = LetterGrammar(Table())


class TestPaper(StrategyContract):
    def plugin(self, space):
        return PaperStrategy(PaperOptions(), space)


class TestPaperWithOneFlipPerOffspring(StrategyContract):
    def plugin(self, space):
        return PaperStrategy(PaperOptions(mutation="per_offspring", population=3), space)


def paper(seed=0, targets=("T1",), **options):
    space = SearchSpace(GRAMMAR, targets, np.random.default_rng(seed))
    return PaperStrategy(PaperOptions(**options), space)


def told(strategy, first, candidates, fitness):
    """Tell one row of fitness for each candidate."""
    rows = np.asarray(fitness, dtype=float).reshape(len(candidates), -1)
    strategy.tell(first, [Evaluation(c.genome, row) for c, row in zip(candidates, rows, strict=True)])


def test_the_wheel_turns_in_proportion_to_fitness():
    np.testing.assert_allclose(roulette_probabilities([1.0, 3.0, 0.0, 4.0]), [1 / 8, 3 / 8, 0, 1 / 2])
    np.testing.assert_array_equal(roulette_probabilities([0.0] * 4), [0.25] * 4)


def test_parents_are_drawn_in_proportion_to_fitness():
    size = 4000
    strategy = paper(population=size, crossover=0, mutation_rate=0)
    first = strategy.ask(size)
    fitness = np.zeros(size)
    fitness[[5, 17, 99]] = 1.0, 3.0, 4.0
    told(strategy, 0, first, fitness)
    drawn = Counter(candidate.parents for candidate in strategy.ask(size))
    assert set(drawn) == {(5,), (17,), (99,)}
    for index, p in ((5, 1 / 8), (17, 3 / 8), (99, 1 / 2)):
        assert abs(drawn[index,] - size * p) < 5 * np.sqrt(size * p * (1 - p))


@pytest.mark.parametrize(("population", "targets"), [(10, 1), (10, 3), (7, 2), (2, 1)])
def test_every_generation_has_one_population_of_constant_size_for_each_target(population, targets):
    names = tuple(f"T{i}" for i in range(targets))
    strategy = paper(1, names, population=population)
    rng = np.random.default_rng(0)
    first = 0
    for generation in range(5):
        candidates = strategy.ask(10_000)
        assert Counter(c.target for c in candidates) == dict.fromkeys(names, population)
        assert {c.generation for c in candidates} == {generation}
        assert all(bool(c.parents) == (generation > 0) for c in candidates)
        told(strategy, first, candidates, rng.random((len(candidates), targets)))
        first += len(candidates)


def test_a_population_descends_from_its_own_targets_individuals_by_that_targets_fitness():
    strategy = paper(2, ("left", "right"), population=10, crossover=1)
    candidates = strategy.ask(20)
    where = {target: [i for i, c in enumerate(candidates) if c.target == target] for target in ("left", "right")}
    fitness = np.zeros((20, 2))
    # Each population's best for its own target is no good for the other one's, and the reverse.
    fitness[where["left"][3]] = fitness[where["right"][4]] = 50.0, 0.0
    fitness[where["left"][5]] = fitness[where["right"][6]] = 0.0, 50.0
    told(strategy, 0, candidates, fitness)
    parents = {
        target: {p for c in strategy_next if c.target == target for p in c.parents}
        for strategy_next in [strategy.ask(20)]
        for target in where
    }
    assert parents == {"left": {where["left"][3]}, "right": {where["right"][6]}}


def test_the_two_offspring_of_a_pair_share_all_their_parents_symbols():
    strategy = paper(4, population=20, crossover=1, mutation_rate=0)
    first = strategy.ask(20)
    told(strategy, 0, first, np.ones(20))
    offspring = strategy.ask(20)
    assert sum(child.genome not in [first[p].genome for p in child.parents] for child in offspring) > 10
    for one, other in zip(offspring[::2], offspring[1::2], strict=True):
        assert one.parents == other.parents and len(one.parents) == 2
        a, b = (first[parent].genome for parent in one.parents)
        for place in range(LENGTH):
            given = sorted([a.symbols[place], b.symbols[place]])
            assert sorted([one.genome.symbols[place], other.genome.symbols[place]]) == given


def test_without_crossover_and_mutation_offspring_are_clones():
    strategy = paper(5, population=11, crossover=0, mutation_rate=0)
    first = strategy.ask(11)
    told(strategy, 0, first, np.ones(11))
    for candidate in strategy.ask(11):
        (parent,) = candidate.parents
        assert candidate.genome == first[parent].genome


def test_the_rate_of_crossover_is_the_share_of_crossed_pairs():
    size = 4000
    strategy = paper(6, population=size, crossover=0.9, mutation_rate=0)
    told(strategy, 0, strategy.ask(size), np.ones(size))
    crossed = sum(len(candidate.parents) == 2 for candidate in strategy.ask(size)) / 2
    pairs = size / 2
    assert abs(crossed - 0.9 * pairs) < 5 * np.sqrt(pairs * 0.9 * 0.1)


def flips(seed, size, **options):
    """How many symbols of each of ``size`` uncrossed offspring were flipped."""
    strategy = paper(seed, population=size, crossover=0, **options)
    first = strategy.ask(size)
    told(strategy, 0, first, np.ones(size))
    pairs = [(c.genome.symbols, first[c.parents[0]].genome.symbols) for c in strategy.ask(size)]
    return np.array([sum(x != y for x, y in zip(*pair, strict=True)) for pair in pairs])


def test_per_symbol_each_symbol_flips_with_the_rate():
    counts = flips(7, 4000, mutation="per_symbol", mutation_rate=0.1)
    n = counts.size * LENGTH
    assert abs(counts.sum() - 0.1 * n) < 5 * np.sqrt(n * 0.1 * 0.9)
    # Independent symbols: the number in an offspring is binomial, so that of those with none is 0.9^12.
    none = 0.9**LENGTH
    spread = np.sqrt(counts.size * none * (1 - none))
    assert abs((counts == 0).sum() - counts.size * none) < 5 * spread
    assert counts.max() > 2


def test_per_offspring_one_symbol_flips_in_a_share_of_them():
    counts = flips(8, 4000, mutation="per_offspring", mutation_rate=0.1)
    assert set(counts) == {0, 1}
    assert abs(counts.sum() - 400) < 5 * np.sqrt(4000 * 0.1 * 0.9)


def test_a_generation_that_the_budget_cuts_leaves_the_other_populations_as_they_were():
    strategy = paper(9, ("left", "right"), population=4, crossover=0, mutation_rate=0)
    first = strategy.ask(8)
    told(strategy, 0, first, np.ones((8, 2)))
    second = strategy.ask(4)
    assert {c.target for c in second} == {"left"}
    told(strategy, 8, second, np.ones((4, 2)))
    third = strategy.ask(8)
    assert {p for c in third if c.target == "left" for p in c.parents} <= set(range(8, 12))
    assert {p for c in third if c.target == "right" for p in c.parents} <= set(range(4, 8))


@pytest.mark.long
def test_a_search_is_the_same_by_either_simulator_within_their_stated_errors():
    studies = [
        load_study("paper", targets=["TP5"], use={"simulator": use}, run={"seed": 1}) for use in (None, "exudyn")
    ]
    strategies, pipelines = ([make(study) for study in studies] for make in (Study.make_strategy, Study.make_pipeline))
    assert [pipeline.simulator.name for pipeline in pipelines] == ["native", "exudyn"]
    for first in range(0, 30, 10):
        asked = [strategy.ask(10) for strategy in strategies]
        assert asked[0] == asked[1]
        flown = [pipeline.evaluate([candidate.genome for candidate in asked[0]]) for pipeline in pipelines]
        for strategy, found in zip(strategies, flown, strict=True):
            strategy.tell(first, found)
        for one, other in zip(*flown, strict=True):
            assert one.fitness == pytest.approx(other.fitness, abs=0.002)
            flights = (one.trajectory, other.trajectory)
            miss, other_miss = (approach_targets(flight, studies[0].scenario)[0] for flight in flights)
            assert np.abs(miss - other_miss).max() < sum(flight.error for flight in flights)
