"""A genome as text: the words of its grammar, and its tuning after ``@`` if it has one."""

from dataclasses import replace
from typing import Any

from driftform.errors import InputError
from driftform.interfaces import Grammar
from driftform.plugins.seams import require_genome
from driftform.types import Genome

MARK = " @ "


def write_genome(grammar: Grammar[Any], genome: Genome) -> str:
    """Return a genome as one line of text."""
    text = grammar.to_text(genome)
    return f"{text}{MARK}{genome.tuning!r}" if genome.tuning else text


def read_genome(grammar: Grammar[Any], text: str) -> Genome:
    """Return the genome that :func:`write_genome` wrote.

    Raises InputError if it does not belong to the grammar, or its tuning is not a number of at least 0.
    """
    words, mark, tuning = text.partition(MARK)
    genome = require_genome(grammar.parse(words), grammar, "parse")
    if not mark:
        return genome
    try:
        value = float(tuning)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise InputError(f"the tuning '{tuning}' should be a number of at least 0")
    return replace(genome, tuning=value)
