"""Genome <-> text, and what is said of bad ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from driftform.errors import InputError
from driftform.types import Genome
from driftform_lsystem.grammar import LSystemGrammar
from driftform_lsystem.options import LSystemOptions

GRAMMAR = LSystemGrammar(LSystemOptions())
FIGURE_2 = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
Q = "addB-tiltn-1-M-moveB"
RULE = f"{Q}-{Q}-{Q}"
GENOTYPE = f"C: {RULE} | S: {RULE} | M: {RULE} | L: {RULE}"


@given(seed=st.integers(0, 2**32 - 1))
def test_a_genotype_survives_the_way_through_text(seed):
    genome = GRAMMAR.random(np.random.default_rng(seed))
    assert GRAMMAR.parse(GRAMMAR.to_text(genome)) == genome


@pytest.mark.parametrize("text", ["C", FIGURE_2, GENOTYPE])
def test_text_is_written_as_it_was_read(text):
    assert GRAMMAR.to_text(GRAMMAR.parse(text)) == text


def test_a_developed_word_starts_with_the_core():
    assert GRAMMAR.parse(Q) == Genome("lsystem", ("C", "addB", "tiltn", "1", "M", "moveB"))
    assert GRAMMAR.parse("C") == Genome("lsystem", ("C",))


@pytest.mark.parametrize("text", [f"C-{Q}", " addB - tiltn-1 -M-\tmoveB\n", f" C - {Q}"])
def test_a_leading_core_and_spaces_do_not_matter(text):
    assert GRAMMAR.parse(text) == GRAMMAR.parse(Q)


def test_the_rules_stand_in_one_order_whatever_the_order_of_the_text():
    a, b = RULE, RULE.replace("addB", "addF")
    assert GRAMMAR.parse(f"L:{b}|C:{a}|M : {a}| S: {b} ") == GRAMMAR.parse(f"C: {a} | S: {b} | M: {a} | L: {b}")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("addB-tiltn-1-M-moveB-addX", "symbol 6 'addX' is not in the alphabet; did you mean 'addF'?"),
        ("addB-tilt-1-M-moveB", "symbol 2 'tilt' is not in the alphabet; did you mean 'tilt"),
        (f"{Q}-addB-tiltx", "symbol 7 'tiltx' is not in the alphabet; did you mean 'tilt"),
        ("addB-tiltn-7-M-moveB", "symbol 3 '7' is not in the alphabet; known: 0, 1, 2, C, L, M, S, addB"),
        ("addB-tiltn-1-m-moveB", "symbol 4 'm' is not in the alphabet; did you mean 'M'?"),
        ("addB-tiltn--M-moveB", "symbol 3 '' is not in the alphabet"),
        ("tiltn-1-M-moveB", "symbol 1 is 'tiltn', expected an add (addF, addB)"),
        ("addB-1-M-moveB", "symbol 2 is '1', expected a tilt (tiltp, tiltn)"),
        ("addB-tiltn-M-moveB", "symbol 3 is 'M', expected a degree (0, 1, 2)"),
        ("addB-tiltn-1-moveB", "symbol 4 is 'moveB', expected a letter (S, M, L)"),
        ("addB-tiltn-1-M-addB", "symbol 5 is 'addB', expected a move (moveF, moveB, moveN)"),
        (f"{Q}-C-{Q}", "symbol 6 is 'C', expected an add (addF, addB)"),
        ("C-addB-M", "symbol 2 is 'M', expected a tilt (tiltp, tiltn)"),
        (f"{Q}-addB-tiltn", "the number of symbols is 7, not a multiple of five (add, tilt, degree, letter, move)"),
        ("", "the genome is empty; expected a word such as addB-tiltn-1-M-moveB, or the rules 'C: ..."),
        (" \n", "the genome is empty"),
        (GENOTYPE.rpartition(" | ")[0], "the number of rules is 3, expected 4 (C, S, M, L); missing: L"),
        (f"S: {RULE}", "the number of rules is 1, expected 4 (C, S, M, L); missing: C, M, L"),
        (f"{GENOTYPE} | L: {RULE}", "rule L is given twice; expected one each for C, S, M, L"),
        (f"{GENOTYPE} | X: {RULE}", "rule 5 of 5 is for 'X'; known: C, L, M, S"),
        (GENOTYPE.replace("S:", "s:"), "rule 2 of 4 is for 's'; did you mean 'S'?"),
        (f"C: {RULE} | {RULE}", "rule 2 of 2 has no letter before a colon; expected a word such as"),
        (GENOTYPE.replace("M: addB-tiltn", "M: addB-tiltx"), "rule M: symbol 2 'tiltx' is not in the alphabet"),
        (GENOTYPE.replace("S: addB-", "S: "), "rule S: symbol 1 is 'tiltn', expected an add (addF, addB)"),
        (f"{GENOTYPE}-addB", "rule L: the number of symbols is 16, not a multiple of five"),
        (f"{GENOTYPE}-{Q}", "rule L: quintuples: 4, expected 3"),
        (f"C: | S: {RULE} | M: {RULE} | L: {RULE}", "rule C: quintuples: 0, expected 3"),
    ],
)
def test_an_error_in_a_text_is_one_line_with_symbol_and_position(text, message):
    with pytest.raises(InputError) as caught:
        GRAMMAR.parse(text)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


GOOD = ("addB", "tiltn", "1", "M", "moveB") * 12


@pytest.mark.parametrize(
    ("genome", "message"),
    [
        (Genome("lsystem", ("C", "addB", "M")), "symbol 2 is 'M', expected a tilt (tiltp, tiltn)"),
        (Genome("lsystem", ("C", "addB", "til\ntn")), "symbol 2 'til\\ntn' is not in the alphabet"),
        (Genome("lsystem", ("C", "addB")), "the number of symbols is 1, not a multiple of five"),
        (Genome("lsystem", (*GOOD[:17], "M", *GOOD[18:])), "rule S: symbol 3 is 'M', expected a degree (0, 1, 2)"),
        (Genome("lsystem", (*GOOD[:59], "move")), "rule L: symbol 15 'move' is not in the alphabet; did you mean"),
        (Genome("lsystem", GOOD[:5]), "the number of symbols is 5, but a genotype has 60, and a developed word"),
        (Genome("lsystem", ()), "the number of symbols is 0, but a genotype has 60"),
        (Genome("other", GOOD), "the genome is one of grammar 'other', not of 'lsystem'"),
    ],
)
def test_a_bad_genome_is_a_value_error_that_says_the_same(genome, message):
    rng = np.random.default_rng(0)
    good = Genome("lsystem", GOOD)
    for take in (
        GRAMMAR.express,
        GRAMMAR.to_text,
        lambda bad: GRAMMAR.flip(bad, 0, rng),
        lambda bad: GRAMMAR.crossover(good, bad, rng),
        lambda bad: GRAMMAR.crossover(bad, good, rng),
    ):
        with pytest.raises(ValueError) as caught:
            take(genome)
        assert str(caught.value).startswith(message)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "table",
    [
        {"small": 0},
        {"large": -1},
        {"iterations": 0},
        {"iterations": 7},
        {"tilt_2_deg": 81},
        {"tilt_1_deg": -1},
        {"repetition": "second"},
        {"occupied": "stack"},
        {"tilt_reference": "core"},
        {"length": 1},
    ],
)
def test_options_out_of_range_are_refused(table):
    with pytest.raises(ValidationError):
        LSystemOptions.model_validate(table)


def test_every_option_has_help_and_every_measure_a_unit():
    for name, field in LSystemOptions.model_fields.items():
        assert field.description
        unit = "deg" if name.endswith("_deg") else "m" if name in {"small", "medium", "large"} else ""
        assert field.json_schema_extra == {"unit": unit}
