"""Symbols <-> one line of text.

A developed word is written as in the paper, ``addB-tiltn-1-M-moveB-...``, and the core alone as ``C``; a
genotype is written as its four rules, ``C: ... | S: ... | M: ... | L: ...``.
"""

from collections.abc import Sequence

from driftform.errors import InputError, did_you_mean
from driftform_lsystem.alphabet import CORE, RULE_LENGTH, RULES
from driftform_lsystem.checking import find_quintuple_fault, find_rule_fault, is_word

_EXPECTED = "expected a word such as addB-tiltn-1-M-moveB, or the rules 'C: ... | S: ... | M: ... | L: ...'"


def write(symbols: Sequence[str]) -> str:
    """Return the text of the symbols of a valid genome."""
    if is_word(symbols):
        return "-".join(symbols[1:]) or CORE
    return " | ".join(
        f"{rule}: {'-'.join(symbols[i * RULE_LENGTH : (i + 1) * RULE_LENGTH])}" for i, rule in enumerate(RULES)
    )


def read(text: str) -> tuple[str, ...]:
    """Return the symbols of a genome's text.

    Whitespace around separators, a word's leading ``C-``, and the order of the rules do not matter.

    Raises InputError if the text is not a genome; the message names the symbol or the rule.
    """
    if not text.strip():
        raise InputError(f"the genome is empty; {_EXPECTED}")
    return _read_genotype(text) if "|" in text or ":" in text else _read_word(text)


def _read_word(text: str) -> tuple[str, ...]:
    symbols = _split(text)
    if symbols[0] == CORE:
        del symbols[0]
    fault = find_quintuple_fault(symbols)
    if fault is not None:
        raise InputError(fault)
    return (CORE, *symbols)


def _read_genotype(text: str) -> tuple[str, ...]:
    rules: dict[str, list[str]] = {}
    parts = text.split("|")
    for number, part in enumerate(parts, start=1):
        head, colon, body = part.partition(":")
        rule = head.strip()
        if not colon:
            raise InputError(f"rule {number} of {len(parts)} has no letter before a colon; {_EXPECTED}")
        if rule not in RULES:
            raise InputError(f"rule {number} of {len(parts)} is for {rule!r}{did_you_mean(rule, RULES)}")
        if rule in rules:
            raise InputError(f"rule {rule} is given twice; expected one each for {', '.join(RULES)}")
        rules[rule] = _split(body)
    missing = [rule for rule in RULES if rule not in rules]
    if missing:
        raise InputError(
            f"the number of rules is {len(rules)}, expected {len(RULES)} ({', '.join(RULES)}); "
            f"missing: {', '.join(missing)}"
        )
    for rule in RULES:
        fault = find_rule_fault(rule, rules[rule])
        if fault is not None:
            raise InputError(fault)
    return tuple(symbol for rule in RULES for symbol in rules[rule])


def _split(text: str) -> list[str]:
    return [symbol.strip() for symbol in text.split("-")] if text.strip() else []
