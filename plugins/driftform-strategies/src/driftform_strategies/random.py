"""Random search: what every search should beat."""

from collections.abc import Sequence
from math import inf

from driftform.interfaces import Strategy, Table, option
from driftform.types import Candidate, Evaluation


class RandomOptions(Table):
    """Options of random search."""

    batch: int = option(100, "candidates per batch", "", gt=0, le=100_000)


class RandomStrategy(Strategy[RandomOptions]):
    """Random search: genomes drawn from the whole space, whatever the outcomes."""

    name = "random"
    Options = RandomOptions

    def ask(self, limit: int) -> list[Candidate]:
        """Return the next batch of random genomes."""
        count = min(limit, self.options.batch)
        # No fitness matters here; the run itself wants the best.
        threshold = (inf,) * len(self.space.targets)
        return [Candidate(self.space.grammar.random(self.space.rng), threshold=threshold) for _ in range(count)]

    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Learn nothing."""

    def can_ask_ahead(self) -> bool:
        """Return True: candidates do not depend on outcomes."""
        return True
