"""A grammar of three letters: the contract of strategies searches it, and it is an example of a small grammar."""

import numpy as np

from driftform.errors import InputError, did_you_mean
from driftform.interfaces import Grammar
from driftform.types import Genome, Module, Morphology
from driftform.util.options import Table

TILTS = {"a": 0.2, "b": 0.0, "c": -0.2}
"""Tilt (rad) of the module that each letter encodes."""

LENGTH = 12
"""Number of letters in a genome: the first half is fore of the core, the second aft."""


class LetterGrammar(Grammar[Table]):
    """Twelve letters a, b or c; each encodes a module of 5 mm that widens, keeps its width or narrows."""

    name = "letters"

    def random(self, rng: np.random.Generator) -> Genome:
        """Return twelve letters, each drawn from the three."""
        return self._genome("".join(rng.choice(list(TILTS), size=LENGTH)))

    def flip(self, genome: Genome, index: int, rng: np.random.Generator) -> Genome:
        """Return the genome with another letter at ``index``."""
        others = [letter for letter in TILTS if letter != genome.symbols[index]]
        letters = list(genome.symbols)
        letters[index] = others[rng.integers(len(others))]
        return self._genome("".join(letters))

    def crossover(self, a: Genome, b: Genome, rng: np.random.Generator) -> tuple[Genome, Genome]:
        """Return the parents with their tails exchanged."""
        cut = int(rng.integers(1, LENGTH))
        x, y = self.to_text(a), self.to_text(b)
        return self._genome(x[:cut] + y[cut:]), self._genome(y[:cut] + x[cut:])

    def express(self, genome: Genome) -> Morphology:
        """Return one module for each letter. Raises ValueError if the genome does not belong to this grammar."""
        if genome.grammar != self.name or (fault := _fault("".join(genome.symbols))):
            raise ValueError(fault if genome.grammar == self.name else f"a genome of {genome.grammar!r}")
        modules = tuple(Module(0.005, TILTS[letter]) for letter in genome.symbols)
        return Morphology(fore=modules[: LENGTH // 2], aft=modules[LENGTH // 2 :])

    def to_text(self, genome: Genome) -> str:
        """Return the letters in a row."""
        return "".join(genome.symbols)

    def parse(self, text: str) -> Genome:
        """Read twelve letters. Raises InputError if the text has other letters, or not twelve."""
        if fault := _fault(text):
            raise InputError(fault)
        return self._genome(text)

    def _genome(self, letters: str) -> Genome:
        return Genome(self.name, tuple(letters))


def _fault(text: str) -> str | None:
    for place, letter in enumerate(text, start=1):
        if letter not in TILTS:
            return f"symbol {place} is {letter!r}{did_you_mean(letter, TILTS)}"
    return None if len(text) == LENGTH else f"the number of symbols is {len(text)}, expected {LENGTH}"
