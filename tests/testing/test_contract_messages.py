"""A contract that fails says what it asks, and what came instead."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from driftform import testing
from driftform.interfaces import Exporter
from driftform.testing import ExporterContract, GrammarContract
from driftform.testing.contract import Contract
from driftform.testing.letters import LetterGrammar
from driftform.util.options import Table


class Listing(LetterGrammar):
    def random(self, rng: np.random.Generator) -> Any:
        return ["a"] * 12


class Silent(Exporter[Table]):
    name = "silent"
    suffix = ".txt"

    def write(self, job: Any, path: Path) -> Any:
        return None


def make(contract: type[Any], plugin: type[Any]) -> Any:
    return type("Mine", (contract,), {"plugin": lambda self: plugin(Table())})()


@pytest.mark.parametrize(
    ("fails", "came", "asked"),
    [
        (
            lambda _: make(GrammarContract, Listing).test_a_random_genome_can_be_expressed(0),
            "grammar 'letters' returned a list from random(), expected a Genome of grammar 'letters'",
            "Every random genome grows into modules of finite length and a tilt below 90 degrees.",
        ),
        (
            lambda path: make(ExporterContract, Silent).test_only_the_requested_files_are_written(path),
            "exporter 'silent' returned nothing from write(), expected the files that it wrote",
            "Every reported file exists, is not empty and has the name of the path, and every file that is written is reported.",
        ),
    ],
)
def test_a_contract_that_fails_says_what_came_and_what_it_asks(
    fails: Callable[[Path], None], came: str, asked: str, tmp_path: Path
) -> None:
    with pytest.raises(AssertionError) as caught:
        fails(tmp_path)
    assert str(caught.value).startswith(came)
    assert caught.value.__notes__ == [f"The contract asks: {asked}"]


def test_every_contract_states_what_each_of_its_tests_asks() -> None:
    contracts = [getattr(testing, name) for name in testing.__all__]
    assert all(issubclass(contract, Contract) for contract in contracts)
    tests = [test for contract in contracts for name, test in vars(contract).items() if name.startswith("test_")]
    assert len(tests) > 80
    assert [test.__qualname__ for test in tests if not test.__doc__] == []
