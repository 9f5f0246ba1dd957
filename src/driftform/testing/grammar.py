"""Contract of grammars."""

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
import pytest

from driftform.errors import InputError
from driftform.interfaces import Grammar
from driftform.plugins.seams import require, require_genome, require_morphology
from driftform.testing.contract import AnsweringContract, Question
from driftform.types import Genome, Morphology

SEEDS = range(12)


class GrammarContract(AnsweringContract[Grammar[Any]]):
    """The contract of grammars.

    Attributes:
        nonsense: texts that are not genomes of the grammar.
    """

    nonsense: ClassVar[tuple[str, ...]] = ("", "   ", "nonsense", "?!", "a genome\nin two lines", "\0")

    def questions(self) -> Sequence[Question]:
        """Return calls of each method, all with a new generator."""
        (a, b), rng = self.draw(3, 2), np.random.default_rng
        calls: list[Question] = [("random", rng(seed)) for seed in range(3)]
        calls += [("flip", a, index, rng(11)) for index in range(len(a.symbols))]
        calls += [("crossover", a, b, rng(11)), ("mutate", a, rng(11), 0.5)]
        return [*calls, ("express", a), ("express", b), ("to_text", b), ("parse", self.plugin().to_text(a))]

    def draw(self, seed: int, count: int = 1) -> list[Genome]:
        """Return random genomes of the grammar."""
        rng = np.random.default_rng(seed)
        grammar = self.plugin()
        return [require_genome(grammar.random(rng), grammar, "random") for _ in range(count)]

    def assert_sound(self, genome: Genome, method: str = "random") -> Morphology:
        """Assert that a genome, which a method returned, belongs to the grammar, and return its morphology."""
        grammar = self.plugin()
        require_genome(genome, grammar, method)
        assert all(type(symbol) is str for symbol in genome.symbols), "a symbol is of a class that derives from str"
        return require_morphology(grammar.express(genome), grammar)

    @pytest.mark.parametrize("seed", SEEDS)
    def test_a_random_genome_can_be_expressed(self, seed: int) -> None:
        """Every random genome grows into modules of finite length and a tilt below 90 degrees."""
        self.assert_sound(self.draw(seed)[0])

    def test_another_seed_draws_another_genome(self) -> None:
        """Randomness comes from the generator that is passed."""
        assert len({genome for seed in SEEDS for genome in self.draw(seed)}) > 1

    def test_the_plain_genome_has_no_modules(self) -> None:
        """A grammar may have a genome of the core alone, and no other is called plain."""
        plain = self.plugin().plain()
        assert plain is None or not self.assert_sound(plain, "plain").modules

    @pytest.mark.parametrize("seed", SEEDS)
    def test_text_round_trips(self, seed: int) -> None:
        """A genome is written on one line, and reading it back gives an equal genome."""
        grammar = self.plugin()
        plain = grammar.plain()
        for genome in (*self.draw(seed, 3), *([plain] if plain else [])):
            text = require(grammar.to_text(genome), str, grammar, "to_text")
            assert len(text.splitlines()) == 1
            assert require_genome(grammar.parse(text), grammar, "parse") == genome

    @pytest.mark.parametrize("seed", SEEDS)
    def test_a_flip_changes_one_symbol_at_most_and_stays_in_the_grammar(self, seed: int) -> None:
        """A flip at any index leaves all other symbols as they are, and can be expressed; some flip changes the genome."""
        (genome,) = self.draw(seed)
        # Not the generator of the genome: a flip that draws a new genome from it would otherwise pass.
        rng = np.random.default_rng([seed, 1])
        flips = [self.plugin().flip(genome, index, rng) for index in range(len(genome.symbols))]
        for index, flipped in enumerate(flips):
            self.assert_sound(flipped, "flip")
            pairs = zip(genome.symbols, flipped.symbols, strict=True)
            assert {i for i, (old, new) in enumerate(pairs) if old != new} <= {index}
        assert any(flipped != genome for flipped in flips)

    @pytest.mark.parametrize("seed", SEEDS)
    def test_offspring_of_a_crossover_stay_in_the_grammar(self, seed: int) -> None:
        """Two genomes have two offspring that can be expressed and bred again."""
        a, b = self.draw(seed, 2)
        rng = np.random.default_rng([seed, 1])
        for _ in range(5):
            a, b = self.plugin().crossover(a, b, rng)
            self.assert_sound(a, "crossover")
            self.assert_sound(b, "crossover")

    @pytest.mark.parametrize("rate", [0.1, 1.0])
    def test_mutants_stay_in_the_grammar(self, rate: float) -> None:
        """A genome can be mutated again and again; at rate 0 no symbol changes."""
        (genome,) = self.draw(1)
        assert self.plugin().mutate(genome, np.random.default_rng(2), 0.0) == genome
        rng = np.random.default_rng(1)
        for _ in range(20):
            genome = self.plugin().mutate(genome, rng, rate)
            self.assert_sound(genome, "mutate")

    def test_another_seed_varies_otherwise(self) -> None:
        """Flip, mutation and crossover draw from the generator that is passed."""
        grammar, (a, b) = self.plugin(), self.draw(3, 2)
        rngs = map(np.random.default_rng, SEEDS)
        assert len({(grammar.flip(a, 0, r), *grammar.crossover(a, b, r), grammar.mutate(a, r, 0.5)) for r in rngs}) > 1

    def test_genomes_are_of_the_genes_that_the_grammar_lists(self) -> None:
        """Symbols of random genomes are among them, and every point of the unit cube is a genome; a grammar may list none."""
        grammar = self.plugin()
        try:
            genes = grammar.list_genes()
        except InputError:
            return
        for genome in self.draw(5, 20):
            for symbol, gene in zip(genome.symbols, genes, strict=True):
                is_text = isinstance(gene[0], str)
                assert symbol in gene if is_text else float(gene[0]) - 1e-5 <= float(symbol) <= float(gene[1]) + 1e-5
        rng, count = np.random.default_rng(6), len(genes)
        for vector in ([0.0] * count, [1.0] * count, *rng.random((10, count))):
            genome = grammar.make_genome(vector)
            self.assert_sound(genome, "make_genome")
            assert grammar.parse(grammar.to_text(genome)) == genome

    def test_text_that_is_not_a_genome_is_an_input_error_with_a_reason(self) -> None:
        """A mistyped genome gives an InputError with a reason, not a traceback."""
        for text in self.nonsense:
            with pytest.raises(InputError) as caught:
                self.plugin().parse(text)
            assert str(caught.value).strip(), f"the error message for {text!r} is empty"

    def test_text_with_a_symbol_missing_is_an_input_error_or_another_genome(self) -> None:
        """A truncated text is never read as the whole genome."""
        grammar = self.plugin()
        (genome,) = self.draw(4)
        text = grammar.to_text(genome)
        for end in range(len(text)):
            try:
                shorter = grammar.parse(text[:end])
            except InputError:
                continue
            assert shorter != genome
            self.assert_sound(shorter)

    def test_a_genome_of_another_grammar_is_a_value_error(self) -> None:
        """A genome holds the name of its grammar, and other grammars reject it."""
        with pytest.raises(ValueError):
            self.plugin().express(Genome("some other grammar", ("no", "symbol", "of", "ours")))
