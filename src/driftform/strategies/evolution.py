"""Evolution by one symbol at a time, each chosen by what it did to an earlier flight."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

import numpy as np

from driftform.interfaces import SearchSpace, Strategy
from driftform.options import Table, option
from driftform.types import Candidate, Evaluation, Genome, Trajectory

MEMBERS = 256
"""Flights that a family remembers, the latest ones."""

NEAREST = 64
"""Members of a family, and changes of symbols, that are considered for one aimed child: the nearest, the smallest."""

GUESSES = 512
"""Combinations of those that are looked at before none is found new."""

TRIES = 8
"""Changes of symbols that are drawn before a child may differ by one more."""

REMEMBERED = 200_000
"""Hashes of genomes and bodies that are kept, so that a body is not flown twice."""


class EvolutionOptions(Table):
    """Options of the evolution."""

    random: int = option(30, "random genomes that it begins with", "", gt=0)
    batch: int = option(20, "children asked for at once", "", gt=0)
    elites: int = option(3, "best flights of each target that its children descend from or aim at", "", gt=0)
    explore: float = option(
        0.5, "share of the children with a change of symbol that their family never tried", "", ge=0, le=1
    )
    pressure: float = option(
        2.0, "targets are worked for in proportion to this power of their error", "", ge=0, le=10
    )
    early: float = option(
        0.125,
        "share of a flight after which paths are compared, before walls blur what a change did",
        "",
        gt=0,
        le=1,
    )
    doubt: float = option(
        0.3, "share of what a change did that it is expected to do otherwise next time", "", ge=0
    )


class Change(NamedTuple):
    """One symbol exchanged for another at a place of the genome."""

    place: int
    old: str
    new: str

    def applied(self, genome: Genome) -> Genome | None:
        """Return the genome with the change made, ``None`` where it has another symbol there."""
        symbols = genome.symbols
        if self.place >= len(symbols) or symbols[self.place] != self.old:
            return None
        return Genome(genome.grammar, (*symbols[: self.place], self.new, *symbols[self.place + 1 :]))


@dataclass(frozen=True, eq=False)
class _Flown:
    """A flight: its evaluation's index, its genome's family, and where it was early on, m, (3,)."""

    index: int
    genome: Genome
    family: "_Family"
    early: tuple[float, ...] | None


@dataclass(eq=False)
class _Family:
    """The descendants of one random genome, and how far each change of a symbol moved the early path of one.

    Attributes
    ----------
    time
        at which early paths are compared, s.
    """

    time: float = 0.0
    members: deque[_Flown] = field(default_factory=lambda: deque(maxlen=MEMBERS))
    moved: dict[Change, tuple[float, ...]] = field(default_factory=dict)

    def learn(self, change: Change, parent: _Flown, child: _Flown) -> None:
        """Remember what a change did, and that undoing it does the opposite."""
        if parent.early is None or child.early is None:
            return
        moved = np.subtract(child.early, parent.early)
        self.moved[change] = tuple(moved.tolist())
        self.moved[Change(change.place, change.new, change.old)] = tuple((-moved).tolist())

    def guesses(self, aim: _Flown, doubt: float) -> Iterator[tuple[_Flown, Change]]:
        """Yield members and changes that should come near the early path of ``aim``, the surest first.

        A child is guessed to be where its parent was, plus what the change did before; ``doubt`` is how far off
        that is, relative to what it did.
        """
        if aim.early is None or not self.moved:
            return
        members, changes = list(self.members), list(self.moved)
        away = np.array([member.early for member in members]) - aim.early
        moved = np.array(list(self.moved.values()))
        size = np.sqrt((moved**2).sum(axis=1))
        near, small = np.argsort((away**2).sum(axis=1))[:NEAREST], np.argsort(size)[:NEAREST]
        miss = np.sqrt(((away[near, None] + moved[small]) ** 2).sum(axis=2)) + doubt * size[small]
        for guess in np.argsort(miss, axis=None)[:GUESSES].tolist():
            row, column = divmod(guess, len(small))
            yield members[near[row]], changes[small[column]]


@dataclass(frozen=True, eq=False)
class _Asked:
    """A candidate, the hash of its body, and how it differs from its parent, where that is by one symbol."""

    candidate: Candidate
    body: int
    parent: _Flown | None = None
    change: Change | None = None


class EvolutionStrategy(Strategy[EvolutionOptions]):
    """One symbol at a time, chosen by what it did to an earlier flight.

    After some random genomes, every child differs by one symbol from a genome that was flown. Each target keeps its
    best flights, its elites, and gets children in proportion to the square of its error. One half of them explore:
    an elite with a change of symbol that its family, the descendants of one random genome, never tried. The other
    half are aimed. A family remembers how far each change moved the early path of a member, an eighth of the flight
    after the release, and takes it to do about the same to every other member. Of all its members and all these changes
    it flies the one that should come nearest to the early path of an elite, and errors of earlier guesses are put
    right by the next. A body that was flown is not flown again.
    """

    name = "evolution"
    Options = EvolutionOptions

    def __init__(self, options: EvolutionOptions, space: SearchSpace) -> None:
        super().__init__(options, space)
        self._elites: list[list[tuple[float, _Flown]]] = [[] for _ in space.targets]
        self._generation = 0
        self._asked: list[_Asked] = []
        self._known: dict[int, None] = {}

    def ask(self, limit: int) -> list[Candidate]:
        """Return random genomes until one has flown with any success, and children after that."""
        batch: list[_Asked] = []
        bodies: set[int] = set()
        if any(self._elites):
            guesses: dict[int, Iterator[tuple[_Flown, Change]]] = {}
            for number in self._worked_for():
                batch.append(self._child(number, bodies, guesses))
        else:
            while len(batch) < self.options.random:
                batch.append(self._random(bodies))
        self._asked = batch[:limit]
        return [asked.candidate for asked in self._asked]

    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Learn from each flight what its change of symbol did, and whether it is one of the best."""
        for index, (asked, evaluation) in enumerate(zip(self._asked, evaluations, strict=True), first):
            self._remember(asked.body)
            self._remember(hash(asked.candidate.genome))
            if evaluation.failure is None:
                self._take(index, asked, evaluation)
        self._generation += 1

    def _take(self, index: int, asked: _Asked, evaluation: Evaluation) -> None:
        flight, parent = evaluation.trajectory, asked.parent
        if parent is not None:
            family = parent.family
        else:
            family = _Family(self.options.early * flight.t[-1] if flight else 0.0)
        early = place_at(flight, family.time) if flight else None
        flown = _Flown(index, evaluation.genome, family, early)
        if early is not None:
            family.members.append(flown)
        if parent is not None and asked.change is not None:
            family.learn(asked.change, parent, flown)
        for elites, fitness in zip(self._elites, evaluation.fitness.tolist(), strict=True):
            if fitness > 0:
                elites.append((fitness, flown))
                elites.sort(key=lambda elite: -elite[0])
                del elites[self.options.elites :]

    def _worked_for(self) -> list[int]:
        """Draw the targets of the next batch."""
        errors = np.array([100 - elites[0][0] if elites else 100.0 for elites in self._elites])
        weights = errors**self.options.pressure
        chance = weights / weights.sum() if weights.any() else None
        return [int(i) for i in self.space.rng.choice(len(errors), size=self.options.batch, p=chance)]

    def _child(
        self, number: int, bodies: set[int], guesses: dict[int, Iterator[tuple[_Flown, Change]]]
    ) -> _Asked:
        rng, elites, target = self.space.rng, self._elites[number], self.space.targets[number]
        if not elites:
            return self._random(bodies)
        # The best every other time, the next one every fourth.
        elite = elites[min(int(rng.geometric(0.5)), len(elites)) - 1][1]
        if rng.random() >= self.options.explore:
            if elite.index not in guesses:
                guesses[elite.index] = elite.family.guesses(elite, self.options.doubt)
            for parent, change in guesses[elite.index]:
                genome = change.applied(parent.genome)
                if genome is not None and (body := self._new_body(genome, bodies)) is not None:
                    candidate = Candidate(genome, (parent.index,), self._generation, target)
                    return _Asked(candidate, body, parent, change)
        return self._explored(elite, target, bodies)

    def _explored(self, elite: _Flown, target: str, bodies: set[int]) -> _Asked:
        rng, grammar = self.space.rng, self.space.grammar
        parent = elite.genome
        for attempt in range(1, 8 * TRIES):
            if not parent.symbols:
                break
            place = int(rng.integers(len(parent.symbols)))
            genome = grammar.flip(parent, place, rng)
            change = _change(parent, genome, place) if parent is elite.genome else None
            if change in elite.family.moved or (body := self._new_body(genome, bodies)) is None:
                if attempt % TRIES == 0:
                    parent = genome
                continue
            candidate = Candidate(genome, (elite.index,), self._generation, target)
            return _Asked(candidate, body, elite, change)
        return self._random(bodies)

    def _random(self, bodies: set[int]) -> _Asked:
        rng, grammar = self.space.rng, self.space.grammar
        for _ in range(TRIES):
            genome = grammar.random(rng)
            body = self._new_body(genome, bodies)
            if body is not None:
                break
        return _Asked(Candidate(genome, (), self._generation), body or 0)

    def _new_body(self, genome: Genome, bodies: set[int]) -> int | None:
        """Return the hash of the body that a genome grows into, ``None`` where that was flown or is asked for."""
        name = hash(genome)
        if name in self._known:
            return None
        try:
            body = hash(self.space.grammar.express(genome))
        except ValueError:
            body = None  # Not every grammar lets each symbol stand beside any other.
        if body is None or body in self._known:
            self._remember(name)
            return None
        if body in bodies:
            return None
        bodies.add(body)
        return body

    def _remember(self, known: int) -> None:
        self._known[known] = None
        if len(self._known) > REMEMBERED:
            self._known = dict.fromkeys(islice(self._known, REMEMBERED // 2, None))


def _change(parent: Genome, child: Genome, place: int) -> Change | None:
    """The change that made a child of its parent, ``None`` where it was more than the symbol at ``place``."""
    change = Change(place, parent.symbols[place], child.symbols[place] if place < len(child.symbols) else "")
    return change if change.applied(parent) == child else None


def place_at(flight: Trajectory, time: float) -> tuple[float, ...]:
    """Return the position at a time (s), m; the last one after the end."""
    after = min(int(np.searchsorted(flight.t, time)), len(flight.t) - 1)
    before = max(after - 1, 0)
    gap = flight.t[after] - flight.t[before]
    share = min(1.0, (time - flight.t[before]) / gap) if gap > 0 else 1.0
    x, y, z = (flight.position[before] + share * (flight.position[after] - flight.position[before])).tolist()
    return x, y, z
