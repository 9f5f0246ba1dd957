"""Random search: the baseline that every study needs."""

from collections.abc import Sequence

from driftform.interfaces import Strategy
from driftform.options import Table, option
from driftform.types import Candidate, Evaluation


class RandomOptions(Table):
    """Options of random search."""

    batch: int = option(100, "candidates asked for at once", "", gt=0)


class RandomStrategy(Strategy[RandomOptions]):
    """Genomes drawn from the whole space, without regard to any outcome."""

    name = "random"
    Options = RandomOptions

    def ask(self, limit: int) -> list[Candidate]:
        """Return the next batch of random genomes."""
        count = min(limit, self.options.batch)
        return [Candidate(self.space.grammar.random(self.space.rng)) for _ in range(count)]

    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Learn nothing."""
