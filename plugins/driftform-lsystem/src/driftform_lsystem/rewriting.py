"""Genotype -> instructions: the parallel rewriting of an L-system, without the repetitions in its word."""

from collections.abc import Sequence

from driftform_lsystem.alphabet import CORE, LETTER_PLACE, LETTERS, QUINTUPLE, QUINTUPLES_PER_RULE, RULES

Step = tuple[str, ...]
"""A quintuple: add, tilt, degree, letter and move."""


def split(symbols: tuple[str, ...]) -> list[Step]:
    """Return symbols without the core's letter as quintuples."""
    width = len(QUINTUPLE)
    return [symbols[k : k + width] for k in range(0, len(symbols), width)]


def grow(genotype: tuple[str, ...], iterations: int, *, last: bool = False) -> list[Step]:
    """Return one quintuple for each module of the word that the axiom C grows into.

    The core's rule keeps its letter, C -> C q q q, and so adds three modules in each iteration. The letters
    S, M, L are consumed, S -> q q q: the symbols around a letter, its "add tilt degree" and its move, remain
    around its children. n modules become 3 n + 3. Of the symbols in a row that this leaves before the first child and
    after the last one, the first counts, or the ``last``.
    """
    quintuples = split(genotype)
    rules = {rule: quintuples[i * QUINTUPLES_PER_RULE : (i + 1) * QUINTUPLES_PER_RULE] for i, rule in enumerate(RULES)}
    # What the letters have grown into so far. An iteration puts what the core's rule has grown into after what is there.
    grown, word = rules, list(rules[CORE])
    for iteration in range(1, iterations):
        if iteration > 1:
            grown = {letter: _replace_letters(rules[letter], grown, last) for letter in LETTERS}
        word += _replace_letters(rules[CORE], grown, last)
    return word


def _replace_letters(rule: Sequence[Step], grown: dict[str, list[Step]], last: bool) -> list[Step]:
    """Return the steps of a rule with each letter replaced by what it has grown into."""
    steps: list[Step] = []
    for step in rule:
        first = len(steps)
        steps += grown[step[LETTER_PLACE]]
        if last:
            steps[-1] = steps[-1][: LETTER_PLACE + 1] + step[LETTER_PLACE + 1 :]
        else:
            steps[first] = step[:LETTER_PLACE] + steps[first][LETTER_PLACE:]
    return steps
