"""Evolution by one symbol at a time, each chosen by what it did to an earlier flight."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from driftform.interfaces import SearchSpace, Strategy
from driftform.options import Table, option
from driftform.types import Candidate, Evaluation, FloatArray, Genome, Trajectory

MEMBERS = 256
"""Flights that a family remembers, the latest ones."""

NEAREST = 64
"""Members of a family, and changes of symbols, that are combined: the nearest, and those that did least."""

GUESSES = 512
"""Combinations that are looked at before it is given up to find a new one among them."""

DRAWS = 4
"""Changes of symbols, or random genomes, that are drawn before it is given up to find a new one."""

REMEMBERED = 200_000
"""Hashes of genomes and bodies that are kept, so that no body flies twice."""

Place: TypeAlias = tuple[float, float, float]


class EvolutionOptions(Table):
    """Options of the evolution."""

    random: int = option(30, "random genomes to begin with", "", gt=0)
    batch: int = option(10, "children asked for at once", "", gt=0)
    elites: int = option(5, "best flights of each target that its children descend from or aim at", "", gt=0)
    explore: float = option(0.5, "share of the children that try out a change of symbol", "", ge=0, le=1)
    pressure: float = option(
        2.0, "a target gets children in proportion to this power of its error", "", ge=0, le=10
    )
    early: float = option(
        0.125,
        "share of a flight after which paths are compared, before walls blur what a change did",
        "",
        gt=0,
        le=1,
    )
    doubt: float = option(
        0.1, "how far off a guess is thought to be, relative to what the change did before", "", ge=0, le=10
    )


class Change(NamedTuple):
    """One symbol exchanged for another at a place of the genome."""

    place: int
    old: str
    new: str

    def undo(self) -> "Change":
        """The way back."""
        return Change(self.place, self.new, self.old)

    def apply(self, genome: Genome) -> Genome | None:
        """Return the genome with the change made, ``None`` where it has another symbol there."""
        symbols = genome.symbols
        if self.place >= len(symbols) or symbols[self.place] != self.old:
            return None
        return Genome(genome.grammar, (*symbols[: self.place], self.new, *symbols[self.place + 1 :]))


@dataclass(frozen=True, eq=False)
class _Flown:
    """A flight: the index of its evaluation, its family, and where it was early on, m, (3,)."""

    index: int
    genome: Genome
    family: "deque[_Flown]"
    early: Place | None


@dataclass(frozen=True, eq=False)
class _Asked:
    """A candidate, the hash of its body, and how it came of its parent, where that was one change of a symbol."""

    candidate: Candidate
    body: int | None
    parent: _Flown | None = None
    change: Change | None = None


class EvolutionStrategy(Strategy[EvolutionOptions]):
    """One symbol at a time, chosen by what it did to an earlier flight.

    After some random genomes, every child differs by one symbol from a genome that was flown. Each target keeps its
    best flights, its elites, and gets children in proportion to the square of its error. Half of them explore: an
    elite with a change of symbol that was never tried. The other half are aimed. How far a change moved the early
    path, an eighth of the flight after the release, is taken for what it does to any genome; of all that descend from
    the same random genome as an elite, and all changes, the two are combined that should come nearest to the elite's
    early path. Where the guess was wrong, the child is one more to start from. No body flies twice.
    """

    name = "evolution"
    Options = EvolutionOptions

    def __init__(self, options: EvolutionOptions, space: SearchSpace) -> None:
        super().__init__(options, space)
        self._elites: list[list[tuple[float, _Flown]]] = [[] for _ in space.targets]
        self._moved: dict[Change, Place] = {}
        self._time: float | None = None
        self._known: dict[int, None] = {}
        self._generation = 0
        self._asked: list[_Asked] = []
        self._asked_bodies: set[int] = set()
        self._guesses: dict[int, Iterator[tuple[_Flown, Change]]] = {}
        self._families: dict[int, tuple[list[_Flown], FloatArray]] = {}
        self._small: tuple[list[Change], FloatArray, FloatArray] | None = None

    def ask(self, limit: int) -> list[Candidate]:
        """Return random genomes until one has flown with any success, and children after that."""
        self._asked_bodies.clear()
        self._guesses.clear()
        self._families.clear()
        self._small = None
        if any(self._elites):
            batch = [self._child(number) for number in self._choose_target()]
        else:
            batch = [self._random() for _ in range(self.options.random)]
        self._asked = batch[:limit]
        return [asked.candidate for asked in self._asked]

    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Learn from each flight what its change of symbol did, and whether it is one of the best."""
        if self._time is None:
            durations = [e.trajectory.t[-1] for e in evaluations if e.trajectory and e.failure is None]
            self._time = self.options.early * float(np.median(durations)) if durations else None
        for index, (asked, evaluation) in enumerate(zip(self._asked, evaluations, strict=True), first):
            self._remember(hash(asked.candidate.genome), asked.body)
            if evaluation.failure is None:
                self._learn(index, asked, evaluation)
        self._generation += 1

    def _learn(self, index: int, asked: _Asked, evaluation: Evaluation) -> None:
        parent, flight = asked.parent, evaluation.trajectory
        early = place_at(flight, self._time) if flight is not None and self._time is not None else None
        family: deque[_Flown] = parent.family if parent else deque(maxlen=MEMBERS)
        flown = _Flown(index, asked.candidate.genome, family, early)
        if early is not None:
            family.append(flown)
            if parent and parent.early and asked.change:
                x, y, z = (after - before for after, before in zip(early, parent.early, strict=True))
                self._moved[asked.change] = x, y, z
                self._moved[asked.change.undo()] = -x, -y, -z
        for elites, fitness in zip(self._elites, evaluation.fitness.tolist(), strict=True):
            if fitness > (elites[-1][0] if len(elites) == self.options.elites else 0):
                elites.append((fitness, flown))
                elites.sort(key=lambda elite: -elite[0])
                del elites[self.options.elites :]

    def _choose_target(self) -> list[int]:
        """Draw the targets that the next batch works for."""
        errors = np.array([100 - elites[0][0] if elites else 100.0 for elites in self._elites])
        weights = errors**self.options.pressure
        chance = weights / weights.sum() if weights.any() else None
        numbers: list[int] = self.space.rng.choice(len(errors), size=self.options.batch, p=chance).tolist()
        return numbers

    def _child(self, number: int) -> _Asked:
        rng, elites, target = self.space.rng, self._elites[number], self.space.targets[number]
        if not elites:
            return self._random()
        # The best every other time, the next one every fourth, and so on.
        _, elite = elites[min(int(rng.geometric(0.5)), len(elites)) - 1]
        ways = (self._explore, self._aim)
        first, second = ways if rng.random() < self.options.explore else ways[::-1]
        return first(elite, target) or second(elite, target) or self._random()

    def _explore(self, elite: _Flown, target: str) -> _Asked | None:
        """An elite with a change that was never tried, ``None`` where such are hard to find."""
        rng, parent = self.space.rng, elite.genome
        for place in rng.integers(max(1, len(parent.symbols)), size=DRAWS).tolist():
            if not parent.symbols:
                break
            genome = self.space.grammar.flip(parent, place, rng)
            change = _change(parent, genome, place)
            if change not in self._moved and (body := self._new_body(genome)) is not None:
                return _Asked(self._candidate(genome, target, elite), body, elite, change)
        return None

    def _aim(self, elite: _Flown, target: str) -> _Asked | None:
        """A member of the family and a change that should come nearest to the elite's early path, if there are any."""
        if elite.index not in self._guesses:
            self._guesses[elite.index] = self._nearest(elite)
        for parent, change in self._guesses[elite.index]:
            genome = change.apply(parent.genome)
            if genome is not None and (body := self._new_body(genome)) is not None:
                return _Asked(self._candidate(genome, target, parent), body, parent, change)
        return None

    def _nearest(self, elite: _Flown) -> Iterator[tuple[_Flown, Change]]:
        """Yield members of the elite's family and changes, those first that should come nearest to its early path."""
        if elite.early is None or not self._moved:
            return
        changes, moved, size = self._smallest()
        members = self._family_of(elite)
        away = members[1] - elite.early
        near = least(np.einsum("ij,ij->i", away, away), NEAREST)
        off = away[near, None] + moved
        miss = np.sqrt(np.einsum("ijk,ijk->ij", off, off)) + self.options.doubt * size
        for guess in least(miss.ravel(), GUESSES).tolist():
            row, column = divmod(guess, len(changes))
            yield members[0][near[row]], changes[column]

    def _family_of(self, elite: _Flown) -> tuple[list[_Flown], FloatArray]:
        """The members of the elite's family, and where they were early on, m, (n, 3)."""
        key = id(elite.family)
        if key not in self._families:
            members = list(elite.family)
            self._families[key] = members, np.array([member.early for member in members])
        return self._families[key]

    def _smallest(self) -> tuple[list[Change], FloatArray, FloatArray]:
        """The changes that moved the early path least, how they moved it, m, (n, 3), and how far, (n,)."""
        if self._small is None:
            changes, moved = list(self._moved), np.array(list(self._moved.values()))
            size = np.sqrt((moved**2).sum(axis=1))
            first = least(size, NEAREST)
            self._small = [changes[i] for i in first.tolist()], moved[first], size[first]
        return self._small

    def _random(self) -> _Asked:
        for _ in range(DRAWS):
            genome = self.space.grammar.random(self.space.rng)
            body = self._new_body(genome)
            if body is not None:
                break
        return _Asked(Candidate(genome, (), self._generation), body)

    def _candidate(self, genome: Genome, target: str, parent: _Flown) -> Candidate:
        return Candidate(genome, (parent.index,), self._generation, target)

    def _new_body(self, genome: Genome) -> int | None:
        """Return the hash of the body that a genome grows into, ``None`` where that has flown or is about to."""
        name = hash(genome)
        if name in self._known:
            return None
        try:
            body = hash(self.space.grammar.express(genome))
        except ValueError:
            # Not in every grammar may each symbol stand beside any other.
            self._remember(name)
            return None
        if body in self._known:
            self._remember(name)
            return None
        if body in self._asked_bodies:
            return None
        self._asked_bodies.add(body)
        return body

    def _remember(self, *hashes: int | None) -> None:
        self._known.update(dict.fromkeys(known for known in hashes if known is not None))
        if len(self._known) > REMEMBERED:
            self._known = dict.fromkeys(islice(self._known, REMEMBERED // 2, None))


def _change(parent: Genome, child: Genome, place: int) -> Change | None:
    """The change that made a child of its parent, ``None`` where it was more than the symbol at ``place``."""
    if len(parent.symbols) != len(child.symbols):
        return None
    change = Change(place, parent.symbols[place], child.symbols[place])
    return change if change.apply(parent) == child else None


def place_at(trajectory: Trajectory, time: float) -> Place:
    """Return the position at a time (s), m; the last one after the end."""
    after = min(int(np.searchsorted(trajectory.t, time)), len(trajectory.t) - 1)
    before = max(after - 1, 0)
    gap = trajectory.t[after] - trajectory.t[before]
    share = min(1.0, (time - trajectory.t[before]) / gap) if gap > 0 else 1.0
    x, y, z = (
        trajectory.position[before] + share * (trajectory.position[after] - trajectory.position[before])
    ).tolist()
    return x, y, z


def least(values: FloatArray, count: int) -> npt.NDArray[np.intp]:
    """Return where the least values are, in their order, at most ``count``.

    >>> least(np.array([3.0, 1.0, 2.0]), 2)
    array([1, 2])
    """
    if len(values) > count:
        chosen = np.argpartition(values, count - 1)[:count]
        return chosen[np.argsort(values[chosen])]
    return np.argsort(values)
