"""A contract that fails says what it asks, and what came instead."""

import pytest

from driftform import testing
from driftform.testing.contract import Contract
from driftform.testing.letters import LetterGrammar
from driftform.util.options import Table


class Listing(LetterGrammar):
    def random(self, rng):
        return ["a"] * 12


class Mine(testing.GrammarContract):
    def plugin(self):
        return Listing(Table())


def test_a_contract_that_fails_says_what_came_and_what_it_asks():
    with pytest.raises(AssertionError) as caught:
        Mine().test_a_random_genome_can_be_expressed(0)
    assert str(caught.value).startswith(
        "grammar 'letters' returned a list from random(), expected a Genome of grammar 'letters'"
    )
    asked = "Every random genome grows into modules of finite length and a tilt below 90 degrees."
    assert caught.value.__notes__ == [f"The contract asks: {asked}"]


def test_every_contract_states_what_each_of_its_tests_asks():
    contracts = [getattr(testing, name) for name in testing.__all__]
    assert all(issubclass(contract, Contract) for contract in contracts)
    tests = [test for contract in contracts for name, test in vars(contract).items() if name.startswith("test_")]
    assert len(tests) > 80
    assert [test.__qualname__ for test in tests if not test.__doc__] == []
