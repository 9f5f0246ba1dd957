"""A grammar of three letters: the contract of strategies searches it, and it is an example of a small grammar."""

from collections.abc import Sequence

import numpy as np

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

    def list_genes(self) -> Sequence[tuple[str, ...]]:
        """Return the three letters for each place."""
        return [tuple(TILTS)] * LENGTH

    def random(self, rng: np.random.Generator) -> Genome:
        """Return twelve letters, each drawn from the three."""
        return Genome(self.name, tuple("".join(rng.choice(list(TILTS), size=LENGTH))))

    def express(self, genome: Genome) -> Morphology:
        """Return one module for each letter. Raises ValueError if the genome does not belong to this grammar."""
        modules = tuple(Module(0.005, TILTS[letter]) for letter in self.read_symbols(genome))
        return Morphology(fore=modules[: LENGTH // 2], aft=modules[LENGTH // 2 :])

    def to_text(self, genome: Genome) -> str:
        """Return the letters in a row."""
        return "".join(genome.symbols)

    def parse(self, text: str) -> Genome:
        """Read twelve letters. Raises InputError if the text has other letters, or not twelve."""
        return super().parse(",".join(text))
