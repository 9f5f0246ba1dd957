"""Contract of strategies."""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import numpy as np
import pytest

from driftform.interfaces import Grammar, SearchSpace, Strategy
from driftform.motion.way import approach_targets, farthest_distances
from driftform.options import Table
from driftform.plugins.seams import require_candidates
from driftform.testing.contract import Contract
from driftform.testing.letters import LetterGrammar
from driftform.types import Candidate, End, Evaluation, FloatArray, Genome, Trajectory
from driftform.water import Pipe, Scenario, Segment

Score = Callable[[Genome], FloatArray]


def two_target_fitness(genome: Genome) -> FloatArray:
    """Return the fitness for two opposite targets, computed from the symbols only, (2,)."""
    share = sum(ord(symbol[0]) % 3 for symbol in genome.symbols) / (2 * len(genome.symbols))
    return np.array([100 * share, 100 * (1 - share)])


def zero_fitness(genome: Genome) -> FloatArray:
    """Return a fitness of zero for two targets, (2,)."""
    return np.zeros(2)


def straight_trajectory(genome: Genome) -> Trajectory:
    """Return a trajectory of 9 m along x that rises or sinks according to the symbols."""
    t = np.linspace(0.0, 9.0, 19)
    course = np.array([1.0, 0.0, (two_target_fitness(genome)[0] - 50) / 250])
    turn = np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 1))
    velocity = np.tile([*course, 0.0, 0.0, 0.0], (len(t), 1))
    return Trajectory(t, t[:, None] * course, turn, velocity, End.OUTLET)


def search_space(grammar: Grammar[Any], targets: tuple[str, ...], seed: int = 0) -> SearchSpace:
    """Return a search space with any number of targets along a pipe of 9 m."""
    segment = Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0)
    points = {name: (9.0 * (i + 1) / (len(targets) + 1), 0.0, 0.0) for i, name in enumerate(targets)}
    scenario = Scenario(pipe=Pipe(segments=(segment,)), targets=points)
    return SearchSpace(grammar, targets, np.random.default_rng(seed), scenario)


class StrategyContract(Contract):
    """Inherit this class, and make the strategy for a search space::

        class TestMyStrategy(StrategyContract):
            def plugin(self, space: SearchSpace) -> MyStrategy:
                return MyStrategy(MyOptions(), space)

    Attributes
    ----------
    targets
        names of the two targets of the contract's fitness.
    """

    targets: ClassVar[tuple[str, str]] = ("left", "right")

    def plugin(self, space: SearchSpace) -> Strategy[Any]:
        """Return the strategy to be tested, at the start of its search."""
        raise NotImplementedError

    def grammar(self) -> Grammar[Any]:
        """Return the grammar to search; override it if the strategy needs a special one."""
        return LetterGrammar(Table())

    def start(self, seed: int = 0) -> Strategy[Any]:
        """Return a new strategy whose random numbers come from the seed."""
        return self.plugin(search_space(self.grammar(), self.targets, seed))

    def ask(self, strategy: Strategy[Any], limit: int, first: int = 0) -> Sequence[Candidate]:
        """Return the next candidates of a strategy that has received ``first`` evaluations."""
        space = strategy.space
        return require_candidates(
            strategy.ask(limit), limit, strategy, space.grammar.name, space.targets, first
        )

    def play(
        self, strategy: Strategy[Any], budget: int, score: Score = two_target_fitness, seconds: float = 0.0
    ) -> list[Candidate]:
        """Ask and tell until the budget is spent; return all candidates in order."""
        asked: list[Candidate] = []
        while len(asked) < budget:
            candidates = self.ask(strategy, budget - len(asked), len(asked))
            outcomes = [
                Evaluation(c.genome, score(c.genome), straight_trajectory(c.genome), seconds=seconds)
                for c in candidates
            ]
            strategy.tell(len(asked), outcomes)
            asked += candidates
        return asked

    def play_ahead(self, strategy: Strategy[Any], budget: int) -> list[Candidate]:
        """Play as a run does, which asks for a batch while another is flown if the strategy can; return all candidates."""
        asked: list[Candidate] = []
        batches: list[Sequence[Candidate]] = []
        told = 0
        while told < budget:
            while len(asked) < budget and (not batches or (len(batches) == 1 and strategy.can_ask_ahead())):
                batches.append(self.ask(strategy, budget - len(asked), len(asked)))
                asked += batches[-1]
            outcomes = [
                Evaluation(c.genome, two_target_fitness(c.genome), straight_trajectory(c.genome))
                for c in batches.pop(0)
            ]
            strategy.tell(told, outcomes)
            told += len(outcomes)
        return asked

    @pytest.mark.parametrize("budget", [1, 13, 99])
    def test_it_may_be_asked_for_a_batch_while_another_is_flown(self, budget: int) -> None:
        """If :meth:`can_ask_ahead` says so; the same seed asks for the same candidates, whatever the budget."""
        whole = self.play_ahead(self.start(8), 150)
        assert len(whole) == 150
        assert find_difference(self.play_ahead(self.start(8), budget), whole[:budget]) is None

    @pytest.mark.parametrize("limit", [1, 2, 3, 7, 20, 1000])
    def test_an_ask_is_never_empty_and_never_beyond_the_limit(self, limit: int) -> None:
        """A batch has at least one candidate, so that the run ends, and at most the remaining number of evaluations."""
        self.ask(self.start(), limit)

    @pytest.mark.parametrize("budget", [1, 13, 100])
    def test_a_budget_is_spent_exactly(self, budget: int) -> None:
        """This holds also if the budget ends in the middle of a batch."""
        assert len(self.play(self.start(), budget)) == budget

    def test_a_budget_may_be_handed_out_in_small_pieces(self) -> None:
        """The strategy works with limits of one to three candidates at a time."""
        strategy = self.start()
        first = 0
        for limit in (1, 2, 3) * 10:
            candidates = self.ask(strategy, limit, first)
            strategy.tell(
                first,
                [
                    Evaluation(c.genome, two_target_fitness(c.genome), straight_trajectory(c.genome))
                    for c in candidates
                ],
            )
            first += len(candidates)

    def test_candidates_are_genomes_of_the_grammar(self) -> None:
        """All candidates can be expressed."""
        grammar = self.grammar()
        for candidate in self.play(self.start(), 100):
            assert candidate.genome.grammar == grammar.name
            grammar.express(candidate.genome)

    def test_parents_are_earlier_evaluations(self) -> None:
        """``Candidate.parents`` are indices of evaluations that ``tell`` received before the candidate was asked for."""
        strategy = self.start()
        first = 0
        for _ in range(6):
            candidates = self.ask(strategy, 40, first)
            strategy.tell(
                first,
                [
                    Evaluation(c.genome, two_target_fitness(c.genome), straight_trajectory(c.genome))
                    for c in candidates
                ],
            )
            first += len(candidates)

    def test_the_same_seed_asks_for_the_same_candidates(self) -> None:
        """All randomness comes from ``space.rng``."""
        assert find_difference(self.play(self.start(3), 100), self.play(self.start(3), 100)) is None

    def test_another_seed_asks_for_other_candidates(self) -> None:
        """The strategy uses ``space.rng``."""
        assert self.play(self.start(3), 40) != self.play(self.start(4), 40)

    def test_a_replay_continues_as_the_run_would_have(self) -> None:
        """A resumed run replays the stored evaluations to a new strategy; their computing times do not matter."""
        whole = self.play(self.start(5), 100)
        replayed = self.play(self.start(5), 100, seconds=17.0)
        assert find_difference(replayed, whole) is None

    def test_a_threshold_has_one_fitness_for_each_target(self) -> None:
        """``Candidate.threshold`` is ``None``, or one number for each target."""
        for candidate in self.play(self.start(), 100):
            assert candidate.threshold is None or len(candidate.threshold) == len(self.targets)
            assert not np.isnan(candidate.threshold or 0.0).any()

    def test_fitness_up_to_the_threshold_does_not_matter(self) -> None:
        """A fitness that exceeds the candidate's threshold for no target can be lower without an effect on the search."""
        strategy, first = self.start(7), 0
        scenario, asked = strategy.space.scenario, list[Candidate]()

        def closeness(genome: Genome) -> FloatArray:
            # A strategy may see a hit by its path, too: both are of the same flight here.
            distances, _ = approach_targets(straight_trajectory(genome), scenario)
            return np.asarray(100 * (1 - distances / farthest_distances(scenario)))

        while len(asked) < 150:
            candidates, outcomes = self.ask(strategy, 150 - len(asked), len(asked)), []
            for candidate in candidates:
                fitness = closeness(candidate.genome)
                if candidate.threshold is not None and np.all(fitness <= candidate.threshold):
                    fitness = np.zeros(2)
                outcomes.append(Evaluation(candidate.genome, fitness, straight_trajectory(candidate.genome)))
            strategy.tell(first, outcomes)
            first += len(candidates)
            asked += candidates
        assert find_difference(asked, self.play(self.start(7), 150, closeness)) is None

    @pytest.mark.parametrize("budget", [1, 13, 60, 99])
    def test_a_larger_budget_begins_with_the_same_candidates(self, budget: int) -> None:
        """The limit shortens a batch without changing its candidates, so that a run can be extended later."""
        longer = self.play(self.start(6), 150)[:budget]
        assert find_difference(self.play(self.start(6), budget), longer) is None

    def test_the_search_continues_if_all_fitness_is_zero(self) -> None:
        """A fitness of zero everywhere does not cause a division by zero, and the search continues."""
        asked = self.play(self.start(), 100, zero_fitness)
        assert len({candidate.genome for candidate in asked}) > 1

    def test_the_search_continues_if_every_evaluation_failed(self) -> None:
        """A failed evaluation has a fitness of zero, and the search continues."""
        strategy = self.start()
        first = 0
        while first < 60:
            candidates = self.ask(strategy, 60 - first, first)
            strategy.tell(first, [Evaluation(c.genome, np.zeros(2), failure="it broke") for c in candidates])
            first += len(candidates)
        self.ask(strategy, 10, first)

    def test_it_works_for_one_target_and_for_many(self) -> None:
        """The strategy does not assume a number of targets."""
        for count in (1, 5):
            targets = tuple(f"T{number}" for number in range(count))
            strategy = self.plugin(search_space(self.grammar(), targets))
            asked = self.play(strategy, 30, lambda genome, n=count: np.full(n, two_target_fitness(genome)[0]))  # type: ignore[misc]
            assert {candidate.target for candidate in asked} <= {*targets, ""}


def find_difference(candidates: Sequence[Candidate], others: Sequence[Candidate]) -> int | None:
    """Return the index of the first candidate that differs, ``None`` if all are the same.

    A plain comparison would do, but a test runner takes minutes to describe how two long lists of genomes differ.
    """
    if list(candidates) == list(others):
        return None
    same = (a == b for a, b in zip(candidates, others, strict=False))
    return next((index for index, equal in enumerate(same) if not equal), min(len(candidates), len(others)))
