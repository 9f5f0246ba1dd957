"""Random search, and the grammar that strategies are tried on."""

import numpy as np

from driftform.interfaces import SearchSpace, Table
from driftform.testing import GrammarContract, StrategyContract
from driftform.testing.letters import LetterGrammar
from driftform.types import Evaluation
from driftform_strategies.random import RandomOptions, RandomStrategy

GRAMMAR = LetterGrammar(Table())


class TestRandom(StrategyContract):
    def plugin(self, space):
        return RandomStrategy(RandomOptions(batch=8), space)


class TestTheGrammarThatStrategiesAreTriedOn(GrammarContract):
    nonsense = (*GrammarContract.nonsense, "abcabcabcabd", "abcabcabcab", "abcabcabcabca")

    def plugin(self):
        return GRAMMAR


def test_random_search_ignores_what_it_is_told():
    def asked(score):
        space = SearchSpace(GRAMMAR, ("T1",), np.random.default_rng(0))
        strategy = RandomStrategy(RandomOptions(batch=5), space)
        genomes = []
        for first in range(0, 20, 5):
            candidates = strategy.ask(100)
            assert len(candidates) == 5
            genomes += [c.genome for c in candidates]
            strategy.tell(first, [Evaluation(c.genome, np.array([score])) for c in candidates])
        return genomes

    assert asked(0.0) == asked(99.0)
    assert asked(0.0) == [GRAMMAR.random(rng) for rng in [np.random.default_rng(0)] for _ in range(20)]
