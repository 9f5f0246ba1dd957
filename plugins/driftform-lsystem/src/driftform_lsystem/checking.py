"""Errors in a sequence of symbols, as one line each.

Positions count from 1 as :mod:`driftform_lsystem.text` prints them: within the named rule of a genotype, and
after the core's letter in a developed word.
"""

from collections.abc import Sequence
from functools import lru_cache

from driftform.errors import did_you_mean
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


def find_rule_fault(rule: str, symbols: Sequence[str]) -> str | None:
    """Return the first fault in one rule of a genotype, or ``None``."""
    fault = find_quintuple_fault(symbols)
    if fault is None and len(symbols) != RULE_LENGTH:
        fault = f"quintuples: {len(symbols) // len(QUINTUPLE)}, expected {QUINTUPLES_PER_RULE}"
    return None if fault is None else f"rule {rule}: {fault}"


# A search varies a few genomes again and again.
@lru_cache(maxsize=256)
def find_fault(symbols: tuple[str, ...]) -> str | None:
    """Return the first fault in the symbols of a genome, or ``None``."""
    if len(symbols) == GENOTYPE_LENGTH and find_quintuple_fault(symbols) is None:
        # The usual case, and the quickest: all rules at once.
        return None
    if is_word(symbols):
        return find_quintuple_fault(symbols[1:])
    if len(symbols) != GENOTYPE_LENGTH:
        return (
            f"the number of symbols is {len(symbols)}, but a genotype has {GENOTYPE_LENGTH}, "
            f"and a developed word starts with {CORE!r}"
        )
    for rule, start in zip(RULES, range(0, GENOTYPE_LENGTH, RULE_LENGTH), strict=True):
        found = find_rule_fault(rule, symbols[start : start + RULE_LENGTH])
        if found is not None:
            return found
    return None


def is_word(symbols: Sequence[str]) -> bool:
    """Return whether the symbols are a developed word, which starts with the core's letter, and not a genotype."""
    return bool(symbols) and symbols[0] == CORE
