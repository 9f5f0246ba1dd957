"""Symbols <-> one line of text, and errors in a sequence of symbols, as one line each.

A developed word is written as in the paper, ``addB-tiltn-1-M-moveB-...``, and the core alone as ``C``; a
genotype is written as its four rules, ``C: ... | S: ... | M: ... | L: ...``. Positions in errors count from 1: within the named
rule of a genotype, and after the core's letter in a developed word.
"""

from collections.abc import Sequence
from functools import lru_cache

from driftform.errors import InputError, did_you_mean
from driftform_lsystem.alphabet import (
    CORE,
    GENOTYPE_LENGTH,
    NOUNS,
    PLACE,
    QUINTUPLE,
    QUINTUPLES_PER_RULE,
    RULE_LENGTH,
    RULES,
)

_EXPECTED = "expected a word such as addB-tiltn-1-M-moveB, or the rules 'C: ... | S: ... | M: ... | L: ...'"


def find_quintuple_fault(symbols: Sequence[str]) -> str | None:
    """Return the first fault in symbols that should be complete quintuples, or ``None``."""
    # Almost all symbols are valid, and comparing all places at once is several times as fast as one by one.
    if list(map(PLACE.get, symbols)) == [*range(len(QUINTUPLE))] * (len(symbols) // len(QUINTUPLE)):
        return None
    for index, symbol in enumerate(symbols):
        wanted = index % len(QUINTUPLE)
        if PLACE.get(symbol) == wanted:
            continue
        if symbol not in PLACE and symbol != CORE:
            hint = did_you_mean(symbol, (*PLACE, CORE))
            return f"symbol {index + 1} {symbol!r} is not in the alphabet{hint}"
        return f"symbol {index + 1} is {symbol!r}, expected {NOUNS[wanted]} ({', '.join(QUINTUPLE[wanted])})"
    if len(symbols) % len(QUINTUPLE):
        five = "a multiple of five (add, tilt, degree, letter, move)"
        return f"the number of symbols is {len(symbols)}, not {five}"
    return None


# A search varies a few genomes again and again.
@lru_cache(maxsize=256)
def find_fault(symbols: tuple[str, ...]) -> str | None:
    """Return the first fault in the symbols of a genome, or ``None``."""
    if is_word(symbols):
        return find_quintuple_fault(symbols[1:])
    if len(symbols) != GENOTYPE_LENGTH:
        return (
            f"the number of symbols is {len(symbols)}, but a genotype has {GENOTYPE_LENGTH}, "
            f"and a developed word starts with {CORE!r}"
        )
    for rule, start in zip(RULES, range(0, GENOTYPE_LENGTH, RULE_LENGTH), strict=True):
        if found := find_quintuple_fault(symbols[start : start + RULE_LENGTH]):
            return f"rule {rule}: {found}"
    return None


def is_word(symbols: Sequence[str]) -> bool:
    """Return whether the symbols are a developed word, which starts with the core's letter, and not a genotype."""
    return bool(symbols) and symbols[0] == CORE


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
    if "|" in text or ":" in text:
        return _read_genotype(text)
    symbols = _split(text)
    if symbols[0] == CORE:
        del symbols[0]
    if fault := find_quintuple_fault(symbols):
        raise InputError(fault)
    return (CORE, *symbols)


def _read_genotype(text: str) -> tuple[str, ...]:
    parts = [part.partition(":") for part in text.split("|")]
    letters = [letter.strip() for letter, _, _ in parts]
    if sorted(letters) != sorted(RULES) or not all(colon for _, colon, _ in parts):
        raise InputError(f"the rules are for {', '.join(map(repr, letters))}; {_EXPECTED}")
    rules = {letter: _split(body) for letter, (_, _, body) in zip(letters, parts, strict=True)}
    for rule in RULES:
        fault, count = find_quintuple_fault(rules[rule]), len(rules[rule]) // len(QUINTUPLE)
        if fault or count != QUINTUPLES_PER_RULE:
            raise InputError(f"rule {rule}: {fault or f'quintuples: {count}, expected {QUINTUPLES_PER_RULE}'}")
    return tuple(symbol for rule in RULES for symbol in rules[rule])


def _split(text: str) -> list[str]:
    return [symbol.strip() for symbol in text.split("-")] if text.strip() else []
