"""Genome <-> text, and what is said of bad ones."""

import pytest

from driftform.errors import InputError
from driftform_lsystem.grammar import LSystemGrammar
from driftform_lsystem.growth import LSystemOptions

GRAMMAR = LSystemGrammar(LSystemOptions())
FIGURE_2 = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
Q = "addB-tiltn-1-M-moveB"
RULE = f"{Q}-{Q}-{Q}"
GENOTYPE = f"C: {RULE} | S: {RULE} | M: {RULE} | L: {RULE}"


@pytest.mark.parametrize("text", ["C", FIGURE_2, GENOTYPE])
def test_text_is_written_as_it_was_read(text):
    assert GRAMMAR.to_text(GRAMMAR.parse(text)) == text


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
        ("tiltn-1-M-moveB", "symbol 1 is 'tiltn', expected an add (addF, addB)"),
        (f"{Q}-C-{Q}", "symbol 6 is 'C', expected an add (addF, addB)"),
        (f"{Q}-addB-tiltn", "the number of symbols is 7, not a multiple of five (add, tilt, degree, letter, move)"),
        ("", "the genome is empty; expected a word such as addB-tiltn-1-M-moveB, or the rules 'C: ..."),
        (GENOTYPE.rpartition(" | ")[0], "the rules are for 'C', 'S', 'M'; expected a word such as"),
        (GENOTYPE.replace("M: addB-tiltn", "M: addB-tiltx"), "rule M: symbol 2 'tiltx' is not in the alphabet"),
        (f"{GENOTYPE}-{Q}", "rule L: quintuples: 4, expected 3"),
    ],
)
def test_an_error_in_a_text_is_one_line_with_symbol_and_position(text, message):
    with pytest.raises(InputError) as caught:
        GRAMMAR.parse(text)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)
