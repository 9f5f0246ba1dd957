"""New results on their way into the store, in the order in which they arrive."""

import time
from collections.abc import Callable, Collection, Sequence

from driftform.runs.store import DisturbedResult, Record, Store
from driftform.types import FloatArray

UNWRITTEN_S = 0.5
"""Most time that flights took which are not written yet, and after which the next is written at once, s: a kill repeats that much.

A disk takes milliseconds to keep what is written, as long as some flights take, whether one or many are written.
"""


class Journal:
    """Evaluations and disturbed flights that are not stored yet; what is left at the end of a ``with`` block is written.

    What a strategy has learned from is therefore never missing where something that it asked for later is stored.

    Args:
        on_record: called with each evaluation once it is stored.
    """

    def __init__(
        self, store: Store, targets: Sequence[str], on_record: Callable[[Record], None] = lambda _: None
    ) -> None:
        self._store, self._targets, self._on_record = store, targets, on_record
        self._records: list[Record] = []
        self._flights: list[DisturbedResult] = []
        self._seconds, self._written = 0.0, time.monotonic()
        # No other process writes meanwhile: of later evaluations nothing was stored before.
        self._stored = store.last_index() + 1

    def __enter__(self) -> "Journal":
        return self

    def __exit__(self, *_: object) -> None:
        # Also where the search is interrupted.
        self.write()

    def add(self, result: Record | DisturbedResult, seconds: float) -> None:
        """Take what a flight of ``seconds`` found; write it, with all before it, if :data:`UNWRITTEN_S` have passed."""
        if isinstance(result, Record):
            self._records.append(result)
        else:
            self._flights.append(result)
        self._seconds += seconds
        # The time of flights is not that of the search, which also asks and waits. No result depends on either.
        if self._seconds > UNWRITTEN_S or time.monotonic() - self._written > UNWRITTEN_S:
            self.write()

    def read_flights(self, indices: Collection[int]) -> dict[tuple[int, int], FloatArray]:
        """Return what :meth:`Store.read_flights` does for evaluations that were stored before this journal began."""
        first = min(indices, default=self._stored)
        return {} if first >= self._stored else self._store.read_flights(self._targets, first, max(indices) + 1)

    def write(self) -> None:
        """Write what is left; what is shown is stored."""
        records, flights = self._records, self._flights
        self._records, self._flights, self._seconds, self._written = [], [], 0.0, time.monotonic()
        if records or flights:
            self._store.add(records, self._targets, flights)
        for record in records:
            self._on_record(record)
