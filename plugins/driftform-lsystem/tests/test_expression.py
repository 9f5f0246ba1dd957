"""Genome -> morphology, against results worked out by hand."""

import math
from collections.abc import Iterable, Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.types import Genome, Module, Morphology
from driftform_lsystem.alphabet import CORE, LETTER_PLACE, PLACE, QUINTUPLE, RULE_LENGTH, RULES
from driftform_lsystem.grammar import LSystemGrammar
from driftform_lsystem.growth import LSystemOptions, interpret

SEEDS = st.integers(0, 2**32 - 1)
LENGTHS = {"S": 0.0025, "M": 0.005, "L": 0.01}
FIGURE_2 = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"


# The L-system as the paper describes it: a word of symbols, rewritten and then read. The grammar never makes the word.


def rewrite(genotype: Sequence[str], iterations: int) -> list[str]:
    """Return the word that the axiom C grows into.

    The core's rule keeps its letter, C -> C q q q, and so adds three modules in each iteration. The letters
    S, M, L are consumed, S -> q q q: the symbols around a letter, its "add tilt degree" and its move, remain
    around its children. n modules become 3 n + 3.
    """
    rules = {rule: list(genotype[i * RULE_LENGTH : (i + 1) * RULE_LENGTH]) for i, rule in enumerate(RULES)}
    rules[CORE].insert(0, CORE)
    word = [CORE]
    for _ in range(iterations):
        grown: list[str] = []
        for symbol in word:
            successor = rules.get(symbol)
            if successor is None:
                grown.append(symbol)
            else:
                grown += successor
        word = grown
    return word


def read_instructions(word: Iterable[str], *, last: bool = False) -> list[list[str]]:
    """Return one quintuple for each module letter of a word.

    Rewriting leaves runs of adds, tilts and degrees before a letter, and of moves after it. The first of each
    run counts, or the ``last``; the rest has no effect.
    """
    steps: list[list[str]] = []
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


def express(word: str, **options: object) -> Morphology:
    """Express a developed word whose symbols are apart by spaces."""
    genome = Genome("lsystem", ("C", *word.split()))
    return LSystemGrammar(LSystemOptions.model_validate(options)).express(genome)


def describe(side: tuple[Module, ...]) -> list[tuple[str, int]]:
    """Return modules as letters and whole degrees, for comparison with results computed by hand."""
    letters = {length: letter for letter, length in LENGTHS.items()}
    return [(letters[module.length], round(math.degrees(module.tilt), 6)) for module in side]


def random_genome(seed: int) -> Genome:
    return LSystemGrammar(LSystemOptions()).random(np.random.default_rng(seed))


def uniform_genotype(quintuple: str) -> Genome:
    return Genome("lsystem", tuple(quintuple.split()) * 12)


def test_figure_2_of_the_paper_is_three_modules_behind_the_core():
    grammar = LSystemGrammar(LSystemOptions())
    morphology = grammar.express(grammar.parse(FIGURE_2))
    assert morphology.fore == ()
    assert [module.length for module in morphology.aft] == [0.005, 0.0025, 0.01]
    assert [module.tilt for module in morphology.aft] == pytest.approx(
        [-math.pi / 18, -math.pi / 9, math.pi / 18], rel=1e-15
    )


def test_two_iterations_build_what_the_rules_say():
    # The word is, with what has no effect in brackets: C, three of "addF tiltp 0 S moveF", then three of
    # "addF tiltp 0 [addB tiltn 1] M moveB, addB tiltn 1 M moveB, addB tiltn 1 M moveB [moveF]".
    genotype = ["addF", "tiltp", "0", "S", "moveF"] * 3 + ["addB", "tiltn", "1", "M", "moveB"] * 3
    genotype += ["addF", "tiltp", "2", "L", "moveN"] * 6
    morphology = LSystemGrammar(LSystemOptions(iterations=2)).express(Genome("lsystem", tuple(genotype)))
    # In what follows the reference is in brackets, s is S at 0, m is M at 0, n is M at -10 degrees.
    # The core's rule:                C s s [s]
    # M fore of the last s, back:     C s [s] s m    for the move goes from s, the reference, to the s before
    # M aft of it, back:              C s [n] s s m
    # M aft of it, back:              C s [n] n s s m
    # M fore of it, back:             C [s] n m n s s m
    # M aft of it, back:              C [n] s n m n s s m
    # M aft of it, back:              C [n] n s n m n s s m
    # M fore of it, back:             [C] n m n s n m n s s m
    # M aft of it, back:              [n] C ...
    # M aft of it, back:              [n] n C ...
    assert describe(morphology.fore) == [
        ("M", -10),
        ("M", 0),
        ("M", -10),
        ("S", 0),
        ("M", -10),
        ("M", 0),
        ("M", -10),
        ("S", 0),
        ("S", 0),
        ("M", 0),
    ]
    assert describe(morphology.aft) == [("M", -10), ("M", -10)]


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
    assert len(grammar.express(uniform_genotype(quintuple)).modules) == modules


RUNS = ["C", "addF", "tiltp", "1", "addB", "tiltn", "2", "S", "moveF", "moveB", "addF", "tiltp", "0", "L", "moveN"]


def test_the_first_of_a_run_counts():
    # S fore of the core at 10 degrees, on to S, L fore of S.
    morphology = interpret(read_instructions(RUNS), LSystemOptions())
    assert describe(morphology.fore) == [("S", 10), ("L", 0)]
    assert morphology.aft == ()


def test_the_last_of_a_run_counts_where_asked_for():
    # S aft of the core at -20 degrees, back to S, L fore of S: between S and the core.
    morphology = interpret(read_instructions(RUNS, last=True), LSystemOptions(repetition="last"))
    assert describe(morphology.aft) == [("L", 0), ("S", -20)]
    assert morphology.fore == ()


@pytest.mark.parametrize("repetition", ["first", "last"])
@given(seed=SEEDS, iterations=st.integers(1, 4))
def test_a_genotype_builds_the_same_as_its_word_without_repetitions(repetition, seed, iterations):
    grammar = LSystemGrammar(LSystemOptions(repetition=repetition, iterations=iterations))
    genome = random_genome(seed)
    steps = read_instructions(rewrite(genome.symbols, iterations), last=repetition == "last")
    word = Genome("lsystem", ("C", *(symbol for step in steps for symbol in step)))
    assert grammar.express(word) == grammar.express(genome)


def test_a_module_is_inserted_next_to_the_reference():
    # The core stays the reference: each module pushes the earlier ones outward.
    morphology = express(
        "addF tiltp 0 S moveN addB tiltp 0 S moveN addF tiltp 1 M moveN addB tiltn 1 M moveN addF tiltp 2 L moveN"
    )
    assert describe(morphology.fore) == [("L", 20), ("M", 10), ("S", 0)]
    assert describe(morphology.aft) == [("M", -10), ("S", 0)]


def test_a_skipped_module_still_moves_the_reference():
    # S fore of the core; M has no place, but moves on to S; L goes fore of S.
    morphology = express("addF tiltp 0 S moveN addF tiltp 1 M moveF addF tiltp 2 L moveN", occupied="skip")
    assert describe(morphology.fore) == [("S", 0), ("L", 20)]
    assert morphology.aft == ()


def test_a_module_is_on_the_side_where_it_ends_up_whatever_added_it():
    # S aft, on to S; L is added forward of S, yet is aft of the core, and widens away from it.
    morphology = express("addB tiltp 0 S moveB addF tiltp 1 L moveN")
    assert describe(morphology.aft) == [("L", 10), ("S", 0)]


def test_a_reference_passes_over_the_core():
    # S and L on either side of the core, on to S. S at 10 degrees fore of it, back to the core. S at 20 fore
    # of the core, back to L. M aft of L.
    morphology = express(
        "addF tiltp 0 S moveN addB tiltp 0 L moveF addF tiltp 1 S moveB addF tiltp 2 S moveB addB tiltp 1 M moveN"
    )
    assert describe(morphology.fore) == [("S", 20), ("S", 0), ("S", 10)]
    assert describe(morphology.aft) == [("L", 0), ("M", 10)]


@pytest.mark.parametrize(("ahead", "behind"), [("F", "B"), ("B", "F")])
def test_a_move_past_the_end_of_the_chain_stays_there_and_is_not_remembered(ahead, behind):
    # S at 0, on to it. M between the core and S, past the end. L between M and S, one back, to L.
    # S at 20 outward of L.
    morphology = express(
        f"add{ahead} tiltp 0 S move{ahead} add{behind} tiltp 0 M move{ahead} "
        f"add{behind} tiltp 0 L move{behind} add{ahead} tiltp 2 S moveN"
    )
    side, other = (morphology.fore, morphology.aft) if ahead == "F" else (morphology.aft, morphology.fore)
    assert describe(side) == [("M", 0), ("L", 0), ("S", 20), ("S", 0)]
    assert other == ()


def test_a_move_from_the_bare_end_of_the_core_stays_at_the_core():
    # Nothing is aft of the core, so the reference stays; M goes between the core and S.
    assert describe(express("addF tiltp 0 S moveB addF tiltp 1 M moveN").fore) == [("M", 10), ("S", 0)]


def test_tilts_against_the_neighbour_add_up_outward_once_all_modules_are_placed():
    # M at -10 is inserted under S, whose wall is then 20 degrees from M's. Aft adds up on its own.
    morphology = express(
        "addF tiltp 2 S moveN addF tiltn 1 M moveN addB tiltp 1 L moveB addB tiltp 2 L moveB",
        tilt_reference="neighbour",
    )
    assert describe(morphology.fore) == [("M", -10), ("S", 10)]
    assert describe(morphology.aft) == [("L", 10), ("L", 30)]


@pytest.mark.parametrize(("tilt", "back", "sign"), [("tiltp", "tiltn", 1), ("tiltn", "tiltp", -1)])
def test_walls_that_lean_on_each_other_stop_at_80_degrees(tilt, back, sign):
    word = f"addB {tilt} 2 S moveB " * 5 + f"addB {back} 1 S moveB"
    tilts = [degrees for _, degrees in describe(express(word, tilt_reference="neighbour").aft)]
    assert tilts == [sign * degrees for degrees in (20, 40, 60, 80, 80, 70)]


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
