"""The contract of strategies is of use only if it refuses strategies that are wrong: each of these has one fault."""

import numpy as np
import pytest

from driftform.testing import StrategyContract
from driftform.types import Candidate
from driftform_strategies.random import RandomOptions, RandomStrategy


class Generations(RandomStrategy):
    """Random search whose candidates count their generations: sound, and the base of the faults."""

    def __init__(self, space):
        super().__init__(RandomOptions(batch=20), space)
        self.generation = 0

    def ask(self, limit):
        drawn = [self.space.grammar.random(self.space.rng) for _ in range(self.options.batch)]
        return [Candidate(genome, (), self.generation) for genome in drawn][:limit]

    def tell(self, first, evaluations):
        self.generation += 1


class SharingTheBudgetOut(Generations):
    """Divides what is left of the budget into ten generations."""

    def ask(self, limit):
        return super().ask(max(1, limit // 10))


class CoolingDown(Generations):
    """Begins with genomes that depend on how long the run will be."""

    def ask(self, limit):
        self.space.rng.random(limit)
        return super().ask(limit)


class EndingWithAFlourish(Generations):
    """Does something special where it sees that the budget ends."""

    def ask(self, limit):
        return super().ask(limit)[:: -1 if limit <= self.options.batch else 1]


class Greedy(Generations):
    """Breeds the best genome so far, and says truly which fitness matters."""

    def __init__(self, space):
        super().__init__(space)
        self.best = 0.0
        self.parent = space.grammar.random(space.rng)

    def ask(self, limit):
        children = [self.space.grammar.mutate(self.parent, self.space.rng, 0.2) for _ in range(20)]
        return [Candidate(genome, threshold=self.threshold()) for genome in children][:limit]

    def tell(self, first, evaluations):
        for evaluation in evaluations:
            if evaluation.fitness[0] > self.best:
                self.best, self.parent = evaluation.fitness[0], evaluation.genome

    def threshold(self):
        return self.best, np.inf


class Disdainful(Greedy):
    """Claims that no fitness matters."""

    def threshold(self):
        return np.inf, np.inf


class OneForAll(Greedy):
    """Gives one number for two targets."""

    def threshold(self):
        return (self.best,)


class Contract(StrategyContract):
    def __init__(self, strategy):
        self.strategy = strategy

    def plugin(self, space):
        return self.strategy(space)


LARGER, BUDGET = "test_a_larger_budget_begins_with_the_same_candidates", {"budget": 13, "ahead": False}


@pytest.mark.parametrize(
    ("sound", "fault", "test", "values"),
    [
        (Generations, SharingTheBudgetOut, LARGER, BUDGET),
        (Generations, CoolingDown, LARGER, BUDGET),
        (Generations, EndingWithAFlourish, LARGER, BUDGET),
        (Greedy, Disdainful, "test_fitness_up_to_the_threshold_does_not_matter", {}),
        (Greedy, OneForAll, "test_candidates_are_genomes_of_the_grammar", {}),
    ],
)
def test_a_faulty_strategy_is_refused(sound, fault, test, values):
    getattr(Contract(sound), test)(**values)
    with pytest.raises(AssertionError):
        getattr(Contract(fault), test)(**values)
