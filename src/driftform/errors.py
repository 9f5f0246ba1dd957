"""Errors that are not bugs of driftform: wrong input and failed work; and the text of errors."""

import re
import traceback
from collections.abc import Iterable, Mapping
from difflib import get_close_matches

__all__ = ["DriftformError", "InputError", "WorkFailedError", "describe_error", "did_you_mean"]

_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")

_LONGEST = 1000
"""Longest message of an error that is shown, characters."""


class DriftformError(Exception):
    """Base class of errors that are shown without a traceback; each argument is one fault, described in one line."""

    exit_code = 1
    """Exit code of the program."""

    in_options: tuple[object, ...] = ()
    """The same faults in the words of the command line, if they differ."""

    def __str__(self) -> str:
        return "\n".join(str(line) for line in self.args)

    def _render_traceback_(self) -> list[str]:
        """Return what a notebook shows in place of a traceback (a hook of IPython)."""
        return [f"{type(self).__name__}: {escape_controls(str(line))}" for line in self.args]


class InputError(DriftformError):
    """The user's input is wrong; the message names the place, the fault and the next step. Exit code 2."""

    exit_code = 2


class WorkFailedError(DriftformError):
    """The input is valid, but the work failed. Exit code 1.

    A grammar or a builder says by ``violations`` how far a body is from one that can be made: by how much each constraint
    is missed, by its name, in SI units.
    """

    def __init__(self, *faults: object, violations: Mapping[str, float] | None = None) -> None:
        super().__init__(*faults)
        self.violations = {str(name): float(excess) for name, excess in (violations or {}).items()}


def describe_error(error: BaseException, *, with_place: bool = False) -> str:
    """Describe an error in one line: its type and message, with the function and line that raised it if asked.

    The message of a :class:`DriftformError` or an ``ImportError`` is for users as it is, without its type.

    >>> describe_error(ValueError("two\\nlines")), describe_error(ImportError("No module named 'exudyn'"))
    ('ValueError: two lines', "No module named 'exudyn'")
    """
    name, message = type(error).__name__, " ".join(_read_message(error).split())
    text = message if isinstance(error, DriftformError | ImportError) else f"{name}: {message}"
    text = text if message else name
    frames = traceback.extract_tb(error.__traceback__) if with_place else []
    return f"{text} (in {frames[-1].name}, line {frames[-1].lineno})" if frames else text


def _read_message(error: BaseException) -> str:
    """Return the message of an error; its class may belong to anybody, and fail to say what failed."""
    try:
        # A database and a terminal refuse text that UTF-8 cannot encode.
        message = str(error).encode("utf-8", "backslashreplace").decode("utf-8")
    except Exception:
        return "no message"
    return message if len(message) <= _LONGEST else f"{message[:_LONGEST]} ..."


def escape_controls(text: str) -> str:
    """Return text without characters that move a cursor or recolour a terminal: texts come from files of others.

    >>> escape_controls("\\x1b[2J Ω")
    '\\\\x1b[2J Ω'
    """
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` if a known word is similar, else the list of known words.

    The result is appended to a message: it starts with a separator, and is empty only if no word is known.
    """
    names = sorted(set(known))
    close = get_close_matches(word, names, n=1, cutoff=0.6) or [n for n in names if n.lower() == word.lower()]
    if close:
        return f"; did you mean '{close[0]}'?"
    return f"; known: {', '.join(names)}" if names else ""


def find_commonest(reasons: Iterable[str]) -> tuple[str, int]:
    """Return the first of the commonest kind of reason, and how many are of that kind; ``("", 0)`` without any.

    Reasons that differ only in their numbers are of one kind.

    >>> find_commonest(["120 mm across", "no genome", "131 mm across"])
    ('120 mm across', 2)
    """
    tally = ReasonTally()
    for reason in reasons:
        tally.add(reason)
    return tally.commonest


class ReasonTally:
    """Counts reasons by their kind as they come: those that differ only in their numbers are of one kind."""

    def __init__(self) -> None:
        self._kinds: dict[str, tuple[str, int]] = {}

    def add(self, reason: str) -> None:
        """Count one reason."""
        kind = _NUMBER.sub("#", reason)
        first, count = self._kinds.get(kind, (reason, 0))
        self._kinds[kind] = (first, count + 1)

    @property
    def commonest(self) -> tuple[str, int]:
        """The first of the commonest kind, and how many are of that kind; ``("", 0)`` without any."""
        return max(list(self._kinds.values()), key=lambda found: found[1], default=("", 0))
