"""Checks of the values that a run's database holds, which may have been written by anybody.

Every function returns the value, or raises a ValueError that names what is wrong with it.
"""

import json
import math
from collections.abc import Mapping
from typing import Any

_LONGEST = 40
"""Characters of a wrong value that are shown."""


def check_integer(value: object, what: str, least: int = 0) -> int:
    """Return an integer of at least ``least``."""
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise _refuse(what, value, f"an integer, at least {least}")
    return value


def check_number(value: object, what: str, least: float = 0.0, most: float = math.inf) -> float:
    """Return a number from ``least`` to ``most``; infinity only if ``most`` is infinite."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= most:
        raise _refuse(what, value, f"a number from {least:g} to {most:g}")
    return float(value)


def check_optional_number(value: object, what: str) -> float | None:
    """Return a number of at least zero, or ``None``."""
    return None if value is None else check_number(value, what)


def check_text(value: object, what: str) -> str:
    """Return a text."""
    if not isinstance(value, str):
        raise _refuse(what, value, "a text")
    return value


def read_texts(value: object, what: str) -> tuple[str, ...]:
    """Return the texts of a JSON array."""
    return tuple(check_text(item, what) for item in _read_list(value, what))


def read_integers(value: object, what: str) -> tuple[int, ...]:
    """Return the integers of a JSON array, none of them negative."""
    return tuple(check_integer(item, what) for item in _read_list(value, what))


def read_study_document(value: object) -> dict[str, Any]:
    """Return the document of a study from its JSON text; its targets are checked, the rest is for ``load_study``."""
    document = json.loads(check_text(value, "the study"), parse_constant=_refuse_constant)
    if not isinstance(document, dict):
        raise _refuse("the study", document, "a table")
    targets = document.get("targets")
    if "targets" in document and not (isinstance(targets, Mapping) and targets):
        raise _refuse("the study's targets", targets, "a table that is not empty")
    for name in targets or ():
        if not name.isprintable():
            raise _refuse("the name of a target", name, "printable text")
    return document


def _read_list(value: object, what: str) -> list[object]:
    found = json.loads(check_text(value, what))
    if not isinstance(found, list):
        raise _refuse(what, found, "a list")
    return found


def _refuse(what: str, value: object, expected: str) -> ValueError:
    shown = repr(value)
    shown = shown if len(shown) <= _LONGEST else f"{shown[:_LONGEST]}..."
    return ValueError(f"{what} is {shown}, expected {expected}")


def _refuse_constant(text: str) -> float:
    raise ValueError(f"the study has {text} in place of a number")
