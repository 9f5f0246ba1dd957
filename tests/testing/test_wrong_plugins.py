"""Contracts are of use only if they refuse what is wrong: mistakes that a run does not notice, each with the test that does."""

import functools

import numpy as np
import pytest
import wrong_plugins

from driftform import testing
from driftform.builtin.fitness import ClosestApproach
from driftform.errors import WorkFailedError
from driftform.plugins.seams import require_scores

CONTRACTS = (
    testing.FitnessContract,
    testing.GrammarContract,
    testing.HydrodynamicsContract,
    testing.PointSimulatorContract,
)


def run(plugin, test, values):
    base = next(sound for sound in wrong_plugins.SOUND if issubclass(plugin, sound))
    contract = CONTRACTS[wrong_plugins.SOUND.index(base)]
    getattr(type("Mine", (contract,), {"plugin": lambda self: plugin(plugin.Options())})(), test)(**values)


@functools.cache
def run_sound(plugin, test, values):
    run(plugin, test, dict(values))


@pytest.mark.parametrize("mistake", wrong_plugins.MISTAKES, ids=lambda mistake: mistake[1])
def test_a_mistake_is_refused_and_the_sound_plugin_is_not(mistake):
    _, test, values = wrong_plugins.MISTAKES[mistake]
    wrong = getattr(wrong_plugins, mistake[1])
    run_sound(wrong.__base__, test, tuple(values.items()))
    with pytest.raises(AssertionError):
        run(wrong, test, values)


def test_a_masked_score_is_refused():
    with pytest.raises(WorkFailedError, match="expected an array of 2 numbers"):
        masked = np.ma.masked_array([50.0, 60.0], mask=[False, True])
        require_scores(masked, 2, ClosestApproach(ClosestApproach.Options()))


def test_every_contract_states_what_each_of_its_tests_asks():
    contracts = [getattr(testing, name) for name in testing.__all__]
    tests = [test for contract in contracts for name, test in vars(contract).items() if name.startswith("test_")]
    assert len(tests) > 80
    assert [test.__qualname__ for test in tests if not test.__doc__] == []
