"""Genome -> morphology, against results worked out by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.types import Genome, Module
from driftform_lsystem.alphabet import CORE, LETTER_PLACE, PLACE, QUINTUPLE, RULE_LENGTH, RULES
from driftform_lsystem.grammar import LSystemGrammar
from driftform_lsystem.growth import LSystemOptions, interpret

SEEDS = st.integers(0, 2**32 - 1)
LENGTHS = {"S": 0.0025, "M": 0.005, "L": 0.01}
FIGURE_2 = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"


# The L-system as the paper describes it: a word of symbols, rewritten and then read. The grammar never makes the word.


def rewrite(genotype, iterations):
    """Return the word that the axiom C grows into.

    The core's rule keeps its letter, C -> C q q q, and so adds three modules in each iteration. The letters
    S, M, L are consumed, S -> q q q: the symbols around a letter, its "add tilt degree" and its move, remain
    around its children. n modules become 3 n + 3.
    """
    rules = {rule: list(genotype[i * RULE_LENGTH : (i + 1) * RULE_LENGTH]) for i, rule in enumerate(RULES)}
    rules[CORE].insert(0, CORE)
    word = [CORE]
    for _ in range(iterations):
        grown = []
        for symbol in word:
            successor = rules.get(symbol)
            if successor is None:
                grown.append(symbol)
            else:
                grown += successor
        word = grown
    return word


def read_instructions(word, *, last=False):
    """Return one quintuple for each module letter of a word.

    Rewriting leaves runs of adds, tilts and degrees before a letter, and of moves after it. The first of each
    run counts, or the ``last``; the rest has no effect.
    """
    steps = []
    step = [""] * len(QUINTUPLE)
    for symbol in word:
        if symbol == CORE:
            continue
        place = PLACE[symbol]
        if place < LETTER_PLACE and step[LETTER_PLACE]:
            steps.append(step)
            step = [""] * len(QUINTUPLE)
        if last or not step[place]:
            step[place] = symbol
    if step[LETTER_PLACE]:
        steps.append(step)
    return steps


def express(word, **options):
    """Express a developed word whose symbols are apart by spaces."""
    genome = Genome("lsystem", ("C", *word.split()))
    return LSystemGrammar(LSystemOptions.model_validate(options)).express(genome)


def describe(morphology):
    """Modules fore and aft as letters and whole degrees, such as ``S0 M-10 | L20``."""
    letters = {length: letter for letter, length in LENGTHS.items()}
    sides = (morphology.fore, morphology.aft)
    named = [" ".join(f"{letters[m.length]}{round(math.degrees(m.tilt), 6):g}" for m in side) for side in sides]
    return " | ".join(named).strip()


def random_genome(seed):
    return LSystemGrammar(LSystemOptions()).random(np.random.default_rng(seed))


def test_figure_2_of_the_paper_is_three_modules_behind_the_core():
    grammar = LSystemGrammar(LSystemOptions())
    morphology = grammar.express(grammar.parse(FIGURE_2))
    assert morphology.fore == ()
    assert [module.length for module in morphology.aft] == [0.005, 0.0025, 0.01]
    assert [module.tilt for module in morphology.aft] == pytest.approx(
        [-math.pi / 18, -math.pi / 9, math.pi / 18], rel=1e-15
    )


@pytest.mark.parametrize(("iterations", "modules"), [(1, 3), (2, 12), (3, 39)])
@given(seed=SEEDS)
def test_n_modules_become_3n_plus_3_with_each_iteration(iterations, modules, seed):
    grammar = LSystemGrammar(LSystemOptions(iterations=iterations))
    assert len(grammar.express(random_genome(seed)).modules) == modules


@given(seed=SEEDS)
def test_inserting_keeps_the_length_of_every_letter_of_the_word(seed):
    genome = random_genome(seed)
    letters = [symbol for symbol in rewrite(genome.symbols, 3) if symbol in LENGTHS]
    total = sum(module.length for module in LSystemGrammar(LSystemOptions()).express(genome).modules)
    assert len(letters) == 39
    assert total == pytest.approx(sum(LENGTHS[letter] for letter in letters), rel=1e-12)
    assert 0.0975 - 1e-12 <= total <= 0.39 + 1e-12


@pytest.mark.parametrize(("quintuple", "modules"), [("addF tiltp 0 S moveN", 1), ("addF tiltp 0 S moveF", 39)])
def test_the_bounds_of_the_number_with_skipping_are_reached(quintuple, modules):
    grammar = LSystemGrammar(LSystemOptions(occupied="skip"))
    genotype = Genome("lsystem", tuple(quintuple.split()) * 12)
    assert len(grammar.express(genotype).modules) == modules


RUNS = ["C", "addF", "tiltp", "1", "addB", "tiltn", "2", "S", "moveF", "moveB", "addF", "tiltp", "0", "L", "moveN"]


def test_the_first_of_a_run_counts_or_the_last_where_asked_for():
    # S fore of the core at 10 degrees, on to S, L fore of S.
    assert describe(interpret(read_instructions(RUNS), LSystemOptions())) == "S10 L0 |"
    # S aft of the core at -20 degrees, back to S, L fore of S: between S and the core.
    found = interpret(read_instructions(RUNS, last=True), LSystemOptions(repetition="last"))
    assert describe(found) == "| L0 S-20"


@pytest.mark.parametrize("repetition", ["first", "last"])
@given(seed=SEEDS, iterations=st.integers(1, 4))
def test_a_genotype_builds_the_same_as_its_word_without_repetitions(repetition, seed, iterations):
    grammar = LSystemGrammar(LSystemOptions(repetition=repetition, iterations=iterations))
    genome = random_genome(seed)
    steps = read_instructions(rewrite(genome.symbols, iterations), last=repetition == "last")
    word = Genome("lsystem", ("C", *(symbol for step in steps for symbol in step)))
    assert grammar.express(word) == grammar.express(genome)


WORDS = {
    # The core stays the reference: each module pushes the earlier ones outward.
    "a module is inserted next to the reference": (
        "addF tiltp 0 S moveN addB tiltp 0 S moveN addF tiltp 1 M moveN addB tiltn 1 M moveN addF tiltp 2 L moveN",
        "L20 M10 S0 | M-10 S0",
    ),
    # S fore of the core; M has no place, but moves on to S; L goes fore of S.
    "a skipped module still moves the reference": (
        "addF tiltp 0 S moveN addF tiltp 1 M moveF addF tiltp 2 L moveN",
        "S0 L20 |",
        {"occupied": "skip"},
    ),
    # S aft, on to S; L is added forward of S, yet is aft of the core, and widens away from it.
    "a module is on the side where it ends up, whatever added it": (
        "addB tiltp 0 S moveB addF tiltp 1 L moveN",
        "| L10 S0",
    ),
    # S and L on either side of the core, on to S. S at 10 degrees fore of it, back to the core. S at 20 fore of the core,
    # back to L. M aft of L.
    "a reference passes over the core": (
        "addF tiltp 0 S moveN addB tiltp 0 L moveF addF tiltp 1 S moveB addF tiltp 2 S moveB addB tiltp 1 M moveN",
        "S20 S0 S10 | L0 M10",
    ),
    # S at 0, on to it. M between the core and S, past the end. L between M and S, one back, to L. S at 20 outward of L.
    "a move past the fore end of the chain stays there and is not remembered": (
        "addF tiltp 0 S moveF addB tiltp 0 M moveF addB tiltp 0 L moveB addF tiltp 2 S moveN",
        "M0 L0 S20 S0 |",
    ),
    "a move past the aft end of the chain stays there and is not remembered": (
        "addB tiltp 0 S moveB addF tiltp 0 M moveB addF tiltp 0 L moveF addB tiltp 2 S moveN",
        "| M0 L0 S20 S0",
    ),
    # Nothing is aft of the core, so the reference stays; M goes between the core and S.
    "a move from the bare end of the core stays at the core": ("addF tiltp 0 S moveB addF tiltp 1 M moveN", "M10 S0 |"),
    # M at -10 is inserted under S, whose wall is then 20 degrees from M's. Aft adds up on its own.
    "tilts against the neighbour add up outward once all modules are placed": (
        "addF tiltp 2 S moveN addF tiltn 1 M moveN addB tiltp 1 L moveB addB tiltp 2 L moveB",
        "M-10 S10 | L10 L30",
        {"tilt_reference": "neighbour"},
    ),
    "outward walls stop at 80 degrees": (
        "addB tiltp 2 S moveB " * 5 + "addB tiltn 1 S moveB",
        "| S20 S40 S60 S80 S80 S70",
        {"tilt_reference": "neighbour"},
    ),
    "inward walls stop at 80 degrees": (
        "addB tiltn 2 S moveB " * 5 + "addB tiltp 1 S moveB",
        "| S-20 S-40 S-60 S-80 S-80 S-70",
        {"tilt_reference": "neighbour"},
    ),
}


@pytest.mark.parametrize("rule", WORDS)
def test_a_word_builds_what_its_rules_say(rule):
    word, built, *options = WORDS[rule]
    assert describe(express(word, **dict(*options))) == built


@pytest.mark.parametrize("tilt_reference", ["axis", "neighbour"])
def test_narrowing_by_nothing_is_a_plain_zero(tilt_reference):
    (module,) = express("addF tiltn 0 S moveN", tilt_reference=tilt_reference).fore
    assert math.copysign(1, module.tilt) == 1


def test_lengths_and_angles_are_the_options():
    options = {"small": 0.1, "medium": 0.2, "large": 0.3, "tilt_0_deg": 1, "tilt_1_deg": 2, "tilt_2_deg": 3}
    word = "addF tiltp 0 S moveF addF tiltn 1 M moveF addF tiltp 2 L moveF"
    assert express(word, **options).fore == (
        Module(0.1, math.radians(1)),
        Module(0.2, -math.radians(2)),
        Module(0.3, math.radians(3)),
    )
