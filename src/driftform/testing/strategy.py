"""Contract of strategies."""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import numpy as np
import pytest

from driftform.interfaces import Grammar, SearchSpace, Strategy
from driftform.motion.path.targets import approach_targets, farthest_distances
from driftform.plugins.seams import require_candidates
from driftform.testing.agents import straight_pipe
from driftform.testing.contract import Contract
from driftform.testing.fitness import straight_trajectory
from driftform.testing.letters import LetterGrammar
from driftform.types import Candidate, Evaluation, FloatArray, Genome, Trajectory
from driftform.util.options import Table
from driftform.water import Scenario

Score = Callable[[Candidate], FloatArray]


def two_target_fitness(genome: Genome) -> FloatArray:
    """Return the fitness for two opposite targets, computed from the symbols only, (2,)."""
    share = sum(ord(symbol[0]) % 3 for symbol in genome.symbols) / (2 * len(genome.symbols))
    return np.array([100 * share, 100 * (1 - share)])


def search_space(grammar: Grammar[Any], targets: tuple[str, ...], seed: int = 0) -> SearchSpace:
    """Return a search space with any number of targets along a pipe of 9 m."""
    points = {name: (9.0 * (i + 1) / (len(targets) + 1), 0.0, 0.0) for i, name in enumerate(targets)}
    scenario = Scenario(pipe=straight_pipe(9.0, 1.0), targets=points)
    return SearchSpace(grammar, targets, np.random.default_rng(seed), scenario)


class StrategyContract(Contract):
    """Inherit this class, and make the strategy for a search space::

        class TestMyStrategy(StrategyContract):
            def plugin(self, space: SearchSpace) -> MyStrategy:
                return MyStrategy(MyOptions(), space)

    Attributes:
        targets: names of the two targets of the contract's fitness.
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
        return require_candidates(strategy.ask(limit), limit, strategy, space.grammar.name, space.targets, first)

    def play(
        self,
        strategy: Strategy[Any],
        budget: int,
        score: Score = lambda candidate: two_target_fitness(candidate.genome),
        *,
        limits: Sequence[int] = (1000,),
        ahead: bool = False,
        **values: Any,
    ) -> list[Candidate]:
        """Ask and tell until the budget is spent; return all candidates in order.

        Each ask is for the next of ``limits``, in turn. ``ahead`` asks for a batch while another is flown, as a run does,
        if the strategy can. ``values`` replace those of each :class:`~driftform.types.Evaluation`, whose times are other ones
        whenever it is played.
        """
        asked: list[Candidate] = []
        batches: list[Sequence[Candidate]] = []
        told = turn = 0
        clock = np.random.default_rng()
        while told < budget:
            while len(asked) < budget and (not batches or (ahead and len(batches) == 1 and strategy.can_ask_ahead())):
                limit = min(limits[turn % len(limits)], budget - len(asked))
                batches.append(self.ask(strategy, limit, told if not ahead else len(asked)))
                asked += batches[-1]
                turn += 1
            outcomes = []
            for candidate in batches.pop(0):
                flight, seconds = _flight_of(candidate.genome), 100 * clock.random()
                flown: dict[str, Any] = {"trajectory": flight, "seconds": seconds} | values
                outcomes.append(Evaluation(candidate.genome, score(candidate), **flown))
            strategy.tell(told, outcomes)
            told += len(outcomes)
        return asked

    @pytest.mark.parametrize(("budget", "limit"), [(1, 1000), (13, 1000), (100, 1000), (60, 3), (240, 40)])
    def test_a_budget_is_spent_exactly(self, budget: int, limit: int) -> None:
        """This holds also if it ends in a batch, or is handed out in pieces; parents are evaluations that ``tell`` received."""
        assert len(self.play(self.start(), budget, limits=(limit, max(1, limit // 2)))) == budget

    def test_candidates_are_genomes_of_the_grammar(self) -> None:
        """All candidates can be expressed."""
        grammar = self.grammar()
        for candidate in self.play(self.start(), 100):
            assert candidate.genome.grammar == grammar.name
            grammar.express(candidate.genome)

    def test_another_seed_asks_for_other_candidates(self) -> None:
        """The strategy uses ``space.rng``."""
        assert self.play(self.start(3), 40) != self.play(self.start(4), 40)

    def test_a_replay_continues_as_the_run_would_have(self) -> None:
        """All randomness comes from ``space.rng``: a resumed run repeats the stored evaluations, in other times."""
        whole = self.play(self.start(5), 100)
        assert find_difference(self.play(self.start(5), 100), whole) is None

    def test_fitness_up_to_the_threshold_does_not_matter(self) -> None:
        """A fitness that exceeds the candidate's threshold for no target can be lower without an effect on the search."""
        strategy = self.start(7)
        scenario = strategy.space.scenario

        def closeness(candidate: Candidate) -> FloatArray:
            # A strategy may see a hit by its path, too: both are of the same flight here.
            distances, _ = approach_targets(_flight_of(candidate.genome), scenario)
            return np.asarray(100 * (1 - distances / farthest_distances(scenario)))

        def what_matters(candidate: Candidate) -> FloatArray:
            fitness, threshold = closeness(candidate), candidate.threshold
            return np.zeros(2) if threshold is not None and np.all(fitness <= threshold) else fitness

        asked = self.play(strategy, 150, what_matters)
        assert find_difference(asked, self.play(self.start(7), 150, closeness)) is None

    @pytest.mark.parametrize("ahead", [False, True])
    @pytest.mark.parametrize("budget", [1, 13, 60, 99])
    def test_a_larger_budget_begins_with_the_same_candidates(self, budget: int, ahead: bool) -> None:
        """The limit shortens a batch without changing its candidates; so does an ask ahead, if :meth:`can_ask_ahead` says yes."""
        longer = self.play(self.start(6), 150, ahead=ahead)
        assert len(longer) == 150
        assert find_difference(self.play(self.start(6), budget, ahead=ahead), longer[:budget]) is None

    def test_the_search_continues_if_all_fitness_is_zero(self) -> None:
        """A fitness of zero everywhere does not cause a division by zero, and the search continues."""
        asked = self.play(self.start(), 100, lambda candidate: np.zeros(2))
        assert len({candidate.genome for candidate in asked}) > 1

    def test_the_search_continues_if_every_evaluation_failed(self) -> None:
        """A failed evaluation has a fitness of zero, and the search continues."""
        strategy = self.start()
        self.play(strategy, 60, lambda candidate: np.zeros(2), trajectory=None, failure="it broke")
        self.ask(strategy, 10, 60)

    def test_it_works_for_one_target_and_for_many(self) -> None:
        """The strategy does not assume a number of targets."""
        for count in (1, 5):
            targets = tuple(f"T{number}" for number in range(count))
            strategy = self.plugin(search_space(self.grammar(), targets))
            asked = self.play(strategy, 30, lambda c, n=count: np.full(n, two_target_fitness(c.genome)[0]))  # type: ignore[misc]
            assert {candidate.target for candidate in asked} <= {*targets, ""}


def _flight_of(genome: Genome) -> Trajectory:
    """Return a trajectory of 9 m along x that rises or sinks according to the symbols."""
    end = (9.0, 0.0, 9.0 * float(two_target_fitness(genome)[0] - 50) / 250)
    return straight_trajectory((0.0, 0.0, 0.0), end, np.linspace(0.0, 9.0, 19))


def find_difference(candidates: Sequence[Candidate], others: Sequence[Candidate]) -> int | None:
    """Return the index of the first candidate that differs, ``None`` if all are the same.

    A plain comparison would do, but a test runner takes minutes to describe how two long lists of genomes differ.
    """
    if list(candidates) == list(others):
        return None
    same = (a == b for a, b in zip(candidates, others, strict=False))
    return next((index for index, equal in enumerate(same) if not equal), min(len(candidates), len(others)))
