"""The L-system of the paper as a grammar of driftform."""

from collections.abc import Iterable, Sequence
from typing import ClassVar

import numpy as np

from driftform.interfaces import Grammar, Table
from driftform.types import Genome, Morphology
from driftform_lsystem import text as lines
from driftform_lsystem.alphabet import CORE, GENOTYPE_LENGTH, OTHERS, QUINTUPLE, RULE_LENGTH, RULES
from driftform_lsystem.growth import LSystemOptions, grow, interpret, split

_CLASSES = QUINTUPLE * (GENOTYPE_LENGTH // len(QUINTUPLE))
_SIZES = np.array([len(symbols) for symbols in _CLASSES])
"""Number of symbols in the class of each place of a genotype, (60,)."""


class LSystemGrammar(Grammar[LSystemOptions]):
    """The paper's L-system (sections 2.2 and 2.3, Table 1).

    A genotype is 60 symbols: the rules of C, S, M and L, each three quintuples of add, tilt, degree, letter
    and move; there are 108^12. A genome that starts with ``"C"`` is an already developed word, C and any
    number of quintuples, and is built without rewriting.
    """

    name = "lsystem"
    Options: ClassVar[type[Table]] = LSystemOptions

    def random(self, rng: np.random.Generator) -> Genome:
        """Return a genotype drawn uniformly from all 108^12."""
        drawn = rng.integers(0, _SIZES).tolist()
        return self._genome([symbols[i] for symbols, i in zip(_CLASSES, drawn, strict=True)])

    def plain(self) -> Genome:
        """Return the core alone, which is a developed word."""
        return self._genome((CORE,))

    def list_genes(self) -> Sequence[tuple[str, ...]]:
        """Return the class of the symbol at each of the 60 places of a genotype."""
        return _CLASSES

    def flip(self, genome: Genome, index: int, rng: np.random.Generator) -> Genome:
        """Return the genome with the symbol at ``index`` changed to another of its class.

        The core's letter at the start of a developed word has no alternative: the genome is then returned
        unchanged.
        Raises ValueError if the genome is not one of this grammar. Raises IndexError if it has no symbol at ``index``.
        """
        self._check(genome)
        symbols = list(genome.symbols)
        if (others := OTHERS.get(symbols[index])) is not None:
            symbols[index] = others[rng.integers(len(others))]
        return self._genome(symbols)

    def crossover(self, a: Genome, b: Genome, rng: np.random.Generator) -> tuple[Genome, Genome]:
        """Return two offspring with the parents' tails swapped at one point, the same in both.

        Genotypes are cut between two rules, developed words between two quintuples; words too short to be cut
        are returned unchanged.

        Raises ValueError if a genome is not one of this grammar, or if one is a genotype and the other a developed
        word.
        """
        self._check(a)
        self._check(b)
        word = lines.is_word(a.symbols)
        if word != lines.is_word(b.symbols):
            raise ValueError("a genotype and a developed word cannot be crossed")
        if word:
            pieces = min(len(a.symbols), len(b.symbols)) // len(QUINTUPLE)
            if pieces < 2:
                return a, b
            cut = 1 + len(QUINTUPLE) * int(rng.integers(1, pieces))
        else:
            cut = RULE_LENGTH * int(rng.integers(1, len(RULES)))
        return (self._genome(a.symbols[:cut] + b.symbols[cut:]), self._genome(b.symbols[:cut] + a.symbols[cut:]))

    def express(self, genome: Genome) -> Morphology:
        """Return the modules that the genome grows into: lengths in m, tilts in rad.

        Raises ValueError if the genome is not one of this grammar; the message names the symbol and its position as
        :meth:`to_text` prints it.
        """
        self._check(genome)
        if lines.is_word(genome.symbols):
            return interpret(split(genome.symbols[1:]), self.options)
        last = self.options.repetition == "last"
        return interpret(grow(genome.symbols, self.options.iterations, last=last), self.options)

    def to_text(self, genome: Genome) -> str:
        """Return a word as the paper prints it, a genotype as ``C: ... | S: ... | M: ... | L: ...``.

        Raises ValueError if the genome is not one of this grammar.
        """
        self._check(genome)
        return lines.write(genome.symbols)

    def parse(self, text: str) -> Genome:
        """Read a genotype or a developed word.

        Raises InputError if the text is neither; the message names the symbol and its position, counted from 1.
        """
        return self._genome(lines.read(text))

    def _genome(self, symbols: Iterable[str]) -> Genome:
        return Genome(self.name, tuple(symbols))

    def _check(self, genome: Genome) -> None:
        if genome.grammar != self.name:
            raise ValueError(f"the genome is one of grammar {genome.grammar!r}, not of {self.name!r}")
        if fault := lines.find_fault(genome.symbols):
            raise ValueError(fault)
