"""Genotype -> word: the parallel rewriting of an L-system."""

from collections.abc import Sequence

from driftform_lsystem.alphabet import CORE, RULE_LENGTH, RULES


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
