"""What chance makes of genomes: random ones, flips and crossovers."""

from collections import Counter

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from driftform.interfaces import Grammar
from driftform.types import Genome
from driftform_lsystem.grammar import LSystemGrammar
from driftform_lsystem.growth import LSystemOptions

SEEDS = st.integers(0, 2**32 - 1)
QUINTUPLES = st.tuples(
    st.sampled_from(["addF", "addB"]),
    st.sampled_from(["tiltp", "tiltn"]),
    st.sampled_from(["0", "1", "2"]),
    st.sampled_from(["S", "M", "L"]),
    st.sampled_from(["moveF", "moveB", "moveN"]),
)
CLASSES = [{"addF", "addB"}, {"tiltp", "tiltn"}, {"0", "1", "2"}, {"S", "M", "L"}, {"moveF", "moveB", "moveN"}]
GRAMMAR = LSystemGrammar(LSystemOptions())


WORDS = st.lists(QUINTUPLES, max_size=8).map(lambda steps: Genome("lsystem", sum(steps, ("C",))))


def rng_of(seed):
    return np.random.default_rng(seed)


def rules(genome):
    return [genome.symbols[i : i + 15] for i in range(0, 60, 15)]


def quintuples(word):
    return [word.symbols[i : i + 5] for i in range(1, len(word.symbols), 5)]


def test_random_symbols_are_uniform_at_every_place():
    rng = rng_of(2024)
    n = 2000
    genomes = [GRAMMAR.random(rng).symbols for _ in range(n)]
    for place in range(60):
        counts = Counter(symbols[place] for symbols in genomes)
        wanted = CLASSES[place % 5]
        assert set(counts) == wanted
        p = 1 / len(wanted)
        # Five standard deviations of a binomial: one in 10 000 sound generators fails at one of 156 counts.
        assert all(abs(count - n * p) < 5 * (n * p * (1 - p)) ** 0.5 for count in counts.values())


@given(seed=SEEDS, index=st.integers(0, 59))
def test_a_flip_changes_one_symbol_within_its_class(seed, index):
    rng = rng_of(seed)
    genome = GRAMMAR.random(rng)
    flipped = GRAMMAR.flip(genome, index, rng)
    assert [i for i in range(60) if flipped.symbols[i] != genome.symbols[i]] == [index]
    assert flipped.symbols[index] in CLASSES[index % 5]
    assert len(GRAMMAR.express(flipped).modules) == 39


def test_a_flip_reaches_every_other_symbol_of_the_class():
    rng = rng_of(0)
    genome = GRAMMAR.parse("addF-tiltp-0-S-moveN")
    seen = [{GRAMMAR.flip(genome, index, rng).symbols[index] for _ in range(100)} for index in range(1, 6)]
    assert seen == [{"addB"}, {"tiltn"}, {"1", "2"}, {"M", "L"}, {"moveF", "moveB"}]


@given(seed=SEEDS, word=WORDS.filter(lambda word: len(word.symbols) > 1), data=st.data())
def test_a_flip_keeps_a_developed_word_one(seed, word, data):
    index = data.draw(st.integers(1, len(word.symbols) - 1))
    flipped = GRAMMAR.flip(word, index, rng_of(seed))
    assert [i for i, symbol in enumerate(flipped.symbols) if symbol != word.symbols[i]] == [index]
    assert len(GRAMMAR.express(flipped).modules) == len(quintuples(word))


@given(seed=SEEDS, word=WORDS)
def test_the_core_of_a_developed_word_never_flips(seed, word):
    assert GRAMMAR.flip(word, 0, rng_of(seed)) == word


@given(seed=SEEDS, rate=st.floats(0, 1))
def test_to_mutate_is_to_flip_one_symbol_after_the_other(seed, rate):
    genome = GRAMMAR.random(rng_of(seed))
    one, other = rng_of(seed), rng_of(seed)
    assert GRAMMAR.mutate(genome, one, rate) == Grammar.mutate(GRAMMAR, genome, other, rate)
    assert one.random() == other.random()


@given(seed=SEEDS)
def test_crossover_swaps_the_rules_after_one_point(seed):
    rng = rng_of(seed)
    a, b = GRAMMAR.random(rng), GRAMMAR.random(rng)
    c, d = GRAMMAR.crossover(a, b, rng)
    assert Counter(rules(c) + rules(d)) == Counter(rules(a) + rules(b))
    whole = [(rules(a)[:k] + rules(b)[k:], rules(b)[:k] + rules(a)[k:]) for k in (1, 2, 3)]
    assert (rules(c), rules(d)) in whole
    assert len(GRAMMAR.express(c).modules) == len(GRAMMAR.express(d).modules) == 39


def test_crossover_uses_each_of_the_three_points():
    rng = rng_of(0)
    a = Genome("lsystem", ("addF", "tiltp", "0", "S", "moveF") * 12)
    b = Genome("lsystem", ("addB", "tiltn", "1", "M", "moveB") * 12)
    points = Counter(GRAMMAR.crossover(a, b, rng)[0].symbols.count("addF") // 3 for _ in range(300))
    assert set(points) == {1, 2, 3}
    # 100 expected of each, with a standard deviation of 8.2.
    assert min(points.values()) > 100 - 5 * 8.2


@given(seed=SEEDS, a=WORDS, b=WORDS)
def test_crossover_of_developed_words_swaps_their_tails_at_a_quintuple(seed, a, b):
    c, d = GRAMMAR.crossover(a, b, rng_of(seed))
    p, q = quintuples(a), quintuples(b)
    shortest = min(len(p), len(q))
    if shortest < 2:
        assert (c, d) == (a, b)
    else:
        whole = [(p[:k] + q[k:], q[:k] + p[k:]) for k in range(1, shortest)]
        assert (quintuples(c), quintuples(d)) in whole
    assert len(GRAMMAR.express(c).modules) == len(quintuples(c))
    assert len(GRAMMAR.express(d).modules) == len(quintuples(d))
