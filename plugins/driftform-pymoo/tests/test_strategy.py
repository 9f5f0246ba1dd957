"""Every algorithm keeps the promises of a strategy, finds an optimum that is known, and returns its front."""

import numpy as np
import pytest
from pydantic import ValidationError

from driftform.errors import InputError
from driftform.interfaces import Grammar, SearchSpace, Table
from driftform.testing import StrategyContract
from driftform.testing.letters import LetterGrammar
from driftform.types import Evaluation
from driftform_bspline.grammar import BSplineGrammar, BSplineOptions
from driftform_pymoo.strategy import PymooOptions, PymooStrategy

GRAMMAR = BSplineGrammar(BSplineOptions(points=1, length=0.11))


class Algorithm(StrategyContract):
    algorithm = "nsga2"
    objectives = ("left", "right")

    def grammar(self):
        return GRAMMAR

    def plugin(self, space):
        objectives = self.objectives if "left" in space.targets else space.targets[: len(self.objectives)]
        objectives = objectives if len(objectives) == len(self.objectives) else ("fitness", space.targets[0])
        return PymooStrategy(PymooOptions(algorithm=self.algorithm, objectives=objectives, population=12), space)


class TestNSGA2(Algorithm):
    pass


class TestNSGA3(Algorithm):
    algorithm = "nsga3"


class TestGA(Algorithm):
    algorithm, objectives = "ga", ("fitness",)


class TestDE(Algorithm):
    algorithm, objectives = "de", ("fitness",)


class TestCMAES(Algorithm):
    algorithm, objectives = "cmaes", ("fitness",)


def search(flights: int, **options) -> tuple[PymooStrategy, list[Evaluation]]:
    """Bodies are longer than allowed if both sides exceed 0.16 m; the fitness grows with the fore side, a measure with both."""
    strategy = PymooStrategy(
        PymooOptions(population=20, **options), SearchSpace(GRAMMAR, ("T",), np.random.default_rng(2))
    )
    found: list[Evaluation] = []
    while len(found) < flights:
        told = []
        for candidate in strategy.ask(flights - len(found)):
            fore, aft = float(candidate.genome.symbols[0]), float(candidate.genome.symbols[2])
            over, measures = max(0.0, fore + aft - 0.16), {"length": fore + aft}
            failure = "too long" if over else None
            told.append(
                Evaluation(
                    candidate.genome,
                    np.array([0.0 if failure else 900 * fore]),
                    failure=failure,
                    measures=measures,
                    violations={"port": over},
                )
            )
        strategy.tell(len(found), told)
        found += told
    return strategy, found


@pytest.mark.parametrize("algorithm", ["nsga2", "ga", "de", "cmaes"])
def test_the_optimum_is_found_within_the_constraint(algorithm):
    _, found = search(600, algorithm=algorithm)
    best = max(found, key=lambda evaluation: evaluation.fitness[0])
    assert best.fitness[0] > 0.97 * 99 and best.failure is None
    assert (
        sum(one.failure is not None for one in found[-100:]) < sum(one.failure is not None for one in found[:100]) + 30
    )


@pytest.mark.parametrize("algorithm", ["nsga2", "nsga3"])
def test_the_front_trades_fitness_for_length(algorithm):
    strategy, found = search(800, algorithm=algorithm, objectives=("fitness", "length"))
    front = strategy.collect_results()["front"]
    assert list(front.axes) == ["fitness", "length"]
    order = np.argsort(front.columns["fitness"])
    fitness, length = front.columns["fitness"][order], front.columns["length"][order]
    assert (np.diff(length) > 0).all()
    # At best the aft side is as short as may be.
    assert np.median(length - fitness / 900) < 0.02 and np.ptp(fitness) > 60
    for index, value in zip(front.columns["evaluation"].astype(int), front.columns["fitness"], strict=True):
        assert found[index].fitness[0] == value and found[index].failure is None


def test_more_of_a_measure_is_better_after_a_minus_sign():
    _, found = search(400, algorithm="ga", objectives=("-length",))
    assert max(one.measures["length"] for one in found if one.failure is None) > 0.158


def test_objectives_that_there_are_not_or_too_many_are_refused_in_one_line():
    with pytest.raises(
        InputError, match=r"strategy\.objectives has 'weight', which no evaluation has; these have length, T, fitness"
    ):
        search(20, objectives=("weight",))
    with pytest.raises(ValidationError, match="'objectives' has 2, and 'de' takes one"):
        PymooOptions(algorithm="de", objectives=("fitness", "mass"))


def test_a_grammar_without_genes_is_refused_in_one_line():
    class NoGenes(LetterGrammar):
        list_genes = Grammar.list_genes

    space = SearchSpace(NoGenes(Table()), ("T",), np.random.default_rng(0))
    with pytest.raises(InputError, match="grammar 'letters' lists no genes"):
        PymooStrategy(PymooOptions(), space)
