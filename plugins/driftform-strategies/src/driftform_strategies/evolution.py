"""Evolution that changes one symbol at a time, chosen by its effect on earlier flights."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from driftform.interfaces import SearchSpace, Strategy, Table, option
from driftform.types import Candidate, Evaluation, FloatArray, Genome, Trajectory

FAMILY_SIZE = 256
"""Number of latest flights that a family keeps."""

COMBINED = 64
"""Number of a family's members (the nearest), and of changes (those with the least effect), that are combined."""

MAX_GUESSES = 512
"""Number of combinations that are tried in the search for one that is new."""

MAX_DRAWS = 4
"""Number of changes, or of random genomes, that are drawn in the search for one that is new."""

MAX_HASHES = 200_000
"""Number of hashes of genomes and bodies that are kept, so that no body flies twice."""


class EvolutionOptions(Table):
    """Options of the evolution."""

    random: int = option(30, "random genomes at the start", "", gt=0, le=10_000_000)
    batch: int = option(5, "children per batch; one batch is made while another is flown", "", gt=0, le=100_000)
    elites: int = option(
        5, "best flights kept for each target; its children descend from them or aim at them", "", gt=0, le=10_000
    )
    explore: float = option(0.5, "share of the children that try a new change of a symbol", "", ge=0, le=1)
    pressure: float = option(
        2.0, "the share of children for a target is proportional to this power of its error", "", ge=0, le=10
    )
    early: float = option(
        0.125,
        "share of the flight after which paths are compared, before contact with walls hides the effect of a change",
        "",
        gt=0,
        le=1,
    )
    doubt: float = option(
        0.1, "assumed error of a guess, relative to the earlier effect of the change", "", ge=0, le=10
    )


class Change(NamedTuple):
    """The replacement of the symbol ``old`` at an index of a genome by ``new``."""

    place: int
    old: str
    new: str

    def undo(self) -> "Change":
        """Return the opposite change."""
        return Change(self.place, self.new, self.old)

    def apply(self, symbols: tuple[str, ...]) -> tuple[str, ...] | None:
        """Return the changed symbols of a genome, or ``None`` if they do not have the symbol ``old`` there."""
        if self.place >= len(symbols) or symbols[self.place] != self.old:
            return None
        return (*symbols[: self.place], self.new, *symbols[self.place + 1 :])


@dataclass(frozen=True, eq=False)
class _FlightRecord:
    """A flight: the index of its evaluation, its genome, its family, its early position (m), and changes that lead nowhere.

    The family are the latest flights of descendants of one random genome, oldest first. Changes that lead nowhere cannot be
    made to its genome, or make a known one: a search would find that out again in every batch.
    """

    index: int
    genome: Genome
    family: "deque[_FlightRecord]"
    early: FloatArray | None
    useless: set[Change] = field(default_factory=set)


@dataclass(frozen=True, eq=False)
class _Request:
    """A candidate, the hash of its body, its parent, and the change if it differs from the parent by one symbol."""

    candidate: Candidate
    body: int | None
    parent: _FlightRecord | None = None
    change: Change | None = None


class EvolutionStrategy(Strategy[EvolutionOptions]):
    """Evolution that changes one symbol at a time, chosen by its effect on earlier flights.

    After some random genomes, every child differs by one symbol from a genome that was flown. Each target keeps its
    best flights, its elites, and gets children in proportion to the square of its error. Half of the children explore:
    an elite with a change that was never tried. The other half are aimed: the displacement of the early path (an eighth
    of the flight after the release) by a change is assumed to be the same for any genome. Among all descendants of the
    same random genome as an elite, and all changes, the strategy combines the two that should come nearest to the
    elite's early path. If the guess was wrong, the child is one more genome to start from. No body flies twice.
    """

    name = "evolution"
    Options = EvolutionOptions

    def __init__(self, options: EvolutionOptions, space: SearchSpace) -> None:
        super().__init__(options, space)
        self._elites: list[list[tuple[float, _FlightRecord]]] = [[] for _ in space.targets]
        # How far each change last moved an early path, m, (3,), and the length of that, m.
        self._moved: dict[Change, tuple[FloatArray, float]] = {}
        self._time: float | None = None
        self._known: dict[int, None] = {}
        self._generation = 0
        self._threshold: tuple[float, ...] = ()
        self._requests: deque[list[_Request]] = deque()
        self._requested_bodies: set[int] = set()
        self._guesses: dict[int, Iterator[tuple[_FlightRecord, Change]]] = {}
        self._small: tuple[list[Change], FloatArray, FloatArray] | None = None

    def ask(self, limit: int) -> list[Candidate]:
        """Return random genomes until one of them has a fitness above zero, and children after that."""
        self._requested_bodies.clear()
        self._guesses.clear()
        self._small = None
        self._threshold = self._find_threshold()
        if any(self._elites):
            batch = [self._make_child(number) for number in self._choose_targets()]
        else:
            batch = [self._draw_random() for _ in range(self.options.random)]
        requests = batch[:limit]
        for request in requests:
            remember(self._known, (hash(request.candidate.genome.symbols), request.body))
        self._requests.append(requests)
        self._generation += 1
        return [request.candidate for request in requests]

    def can_ask_ahead(self) -> bool:
        """Return True once there are elites: a child of the batch before last is as good as one of the last."""
        return any(self._elites)

    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Learn the effect of each change, and keep the best flights."""
        if self._time is None:
            durations = [e.trajectory.t[-1] for e in evaluations if e.trajectory and e.failure is None]
            self._time = self.options.early * float(np.median(durations)) if durations else None
        requests = self._requests.popleft()
        for index, (request, evaluation) in enumerate(zip(requests, evaluations, strict=True), first):
            if evaluation.failure is None:
                self._learn(index, request, evaluation)

    def _learn(self, index: int, request: _Request, evaluation: Evaluation) -> None:
        parent, trajectory = request.parent, evaluation.trajectory
        early = position_at(trajectory, self._time) if trajectory is not None and self._time is not None else None
        family = parent.family if parent else deque(maxlen=FAMILY_SIZE)
        record = _FlightRecord(index, request.candidate.genome, family, early)
        if early is not None:
            family.append(record)
            if parent and parent.early is not None and request.change:
                moved = early - parent.early
                size = float(np.sqrt(moved @ moved))
                self._moved |= {request.change: (moved, size), request.change.undo(): (-moved, size)}
        for elites, fitness, least in zip(
            self._elites, evaluation.fitness.tolist(), self._find_threshold(), strict=True
        ):
            if fitness > least:
                elites.append((fitness, record))
                elites.sort(key=lambda elite: -elite[0])
                del elites[self.options.elites :]

    def _find_threshold(self) -> tuple[float, ...]:
        """Return the fitness for each target (%) that a flight must exceed to become an elite."""
        return tuple(elites[-1][0] if len(elites) == self.options.elites else 0.0 for elites in self._elites)

    def _choose_targets(self) -> list[int]:
        """Return randomly drawn indices of the targets that the next batch works for."""
        errors = np.array([100 - elites[0][0] if elites else 100.0 for elites in self._elites])
        weights = errors**self.options.pressure
        chance = weights / weights.sum() if weights.any() else None
        return list(map(int, self.space.rng.choice(len(errors), size=self.options.batch, p=chance)))

    def _make_child(self, number: int) -> _Request:
        rng, elites, target = self.space.rng, self._elites[number], self.space.targets[number]
        if not elites:
            return self._draw_random()
        # The best with probability 1/2, the second with 1/4, and so on.
        _, elite = elites[min(int(rng.geometric(0.5)), len(elites)) - 1]
        ways = (self._explore, self._aim)
        first, second = ways if rng.random() < self.options.explore else ways[::-1]
        return first(elite, target) or second(elite, target) or self._draw_random()

    def _explore(self, elite: _FlightRecord, target: str) -> _Request | None:
        """Return an elite with a change that was never tried, or ``None`` if none is found."""
        rng, parent = self.space.rng, elite.genome
        for place in rng.integers(max(1, len(parent.symbols)), size=MAX_DRAWS).tolist():
            if not parent.symbols:
                break
            genome = self.space.grammar.flip(parent, place, rng)
            change = _find_change(parent, genome, place)
            if change not in self._moved and (body := self._hash_new_body(genome)) is not None:
                return _Request(self._make_candidate(genome, target, elite), body, elite, change)
        return None

    def _aim(self, elite: _FlightRecord, target: str) -> _Request | None:
        """Return the member of the family and the change that should come nearest to the elite's early path, or ``None``."""
        if elite.index not in self._guesses:
            self._guesses[elite.index] = self._rank_guesses(elite)
        for parent, change in self._guesses[elite.index]:
            if change in parent.useless:
                continue
            symbols = change.apply(parent.genome.symbols)
            if symbols is None or hash(symbols) in self._known:
                parent.useless.add(change)
                continue
            genome = Genome(parent.genome.grammar, symbols)
            if (body := self._hash_new_body(genome)) is not None:
                return _Request(self._make_candidate(genome, target, parent), body, parent, change)
        return None

    def _rank_guesses(self, elite: _FlightRecord) -> Iterator[tuple[_FlightRecord, Change]]:
        """Return members of the elite's family with changes, in the order of their expected distance from its path."""
        if elite.early is None or not self._moved:
            return iter(())
        if self._small is None:
            # The changes that moved least.
            known, sizes = list(self._moved), np.array([size for _, size in self._moved.values()])
            least = smallest_indices(sizes, COMBINED)
            changes = list(map(known.__getitem__, least.tolist()))
            self._small = changes, np.array([self._moved[change][0] for change in changes]), sizes[least]
        changes, moved, size = self._small
        away = np.array([member.early for member in elite.family]) - elite.early
        near = smallest_indices(np.einsum("ij,ij->i", away, away), COMBINED)
        # Coordinate by coordinate: loops over three numbers would take twice the time.
        squares = [np.add.outer(here, there) ** 2 for here, there in zip(away[near].T, moved.T, strict=True)]
        miss = np.sqrt(squares[0] + squares[1] + squares[2]) + self.options.doubt * size
        rows, columns = np.divmod(smallest_indices(miss.ravel(), MAX_GUESSES), len(changes))
        nearest = list(map(elite.family.__getitem__, near.tolist()))
        return zip(map(nearest.__getitem__, rows.tolist()), map(changes.__getitem__, columns.tolist()), strict=True)

    def _draw_random(self) -> _Request:
        for _ in range(MAX_DRAWS):
            genome = self.space.grammar.random(self.space.rng)
            body = self._hash_new_body(genome)
            if body is not None:
                break
        return _Request(Candidate(genome, (), self._generation, threshold=self._threshold), body)

    def _make_candidate(self, genome: Genome, target: str, parent: _FlightRecord) -> Candidate:
        return Candidate(genome, (parent.index,), self._generation, target, self._threshold)

    def _hash_new_body(self, genome: Genome) -> int | None:
        """Return the hash of the body that a genome grows into, or ``None`` if that body was already asked for."""
        name = hash(genome.symbols)
        if name in self._known:
            return None
        try:
            body = hash(self.space.grammar.express(genome))
        except ValueError:
            # A grammar may forbid some combinations of symbols.
            body = None
        if body is None or body in self._known:
            remember(self._known, [name])
            return None
        if body in self._requested_bodies:
            return None
        self._requested_bodies.add(body)
        return body


def _find_change(parent: Genome, child: Genome, place: int) -> Change | None:
    """Return the change from parent to child, or ``None`` if more than the symbol at ``place`` differs."""
    if len(parent.symbols) != len(child.symbols):
        return None
    change = Change(place, parent.symbols[place], child.symbols[place])
    return change if change.apply(parent.symbols) == child.symbols else None


def remember(known: dict[int, None], hashes: Iterable[int | None]) -> None:
    """Add hashes to those that are known, and forget the earlier half once there are more than :data:`MAX_HASHES`."""
    known.update((name, None) for name in hashes if name is not None)
    if len(known) > MAX_HASHES:
        for early in list(islice(known, MAX_HASHES // 2)):
            del known[early]


def position_at(trajectory: Trajectory, time: float) -> FloatArray:
    """Return the linearly interpolated position (m, (3,)) at a time (s); the last position after the end."""
    t, position = trajectory.t, trajectory.position
    after = min(int(t.searchsorted(time)), len(t) - 1)
    before = max(after - 1, 0)
    gap = t[after] - t[before]
    share = min(1.0, (time - t[before]) / gap) if gap > 0 else 1.0
    return np.asarray(position[before] + share * (position[after] - position[before]))


def smallest_indices(values: FloatArray, count: int) -> npt.NDArray[np.intp]:
    """Return the indices of the ``count`` smallest values, smallest first.

    >>> smallest_indices(np.array([3.0, 1.0, 2.0]), 2)
    array([1, 2])
    """
    if len(values) > count:
        chosen = values.argpartition(count - 1)[:count]
        return chosen[values[chosen].argsort()]
    return values.argsort()
