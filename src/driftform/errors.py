"""What may go wrong that is not our bug: the user's input, and work that failed."""

import traceback
from collections.abc import Iterable
from difflib import get_close_matches


class DriftformError(Exception):
    """Base of the errors that a user sees without a traceback: each argument is one thing wrong, told in one line."""

    exit_code = 1
    """What the program ends with."""

    def __str__(self) -> str:
        return "\n".join(str(line) for line in self.args)


class InputError(DriftformError):
    """The user's input is wrong: the message names where, what, and the next step. Exit code 2."""

    exit_code = 2


class WorkFailedError(DriftformError):
    """The input was right, the work failed. Exit code 1."""


def describe_error(error: BaseException, *, with_place: bool = False) -> str:
    """Describe an error in one line: its type and message, with the function and line that raised it if asked.

    The message of a :class:`DriftformError` or an ``ImportError`` is for users as it is, without its type.

    >>> describe_error(ValueError("two\\nlines")), describe_error(ImportError("No module named 'exudyn'"))
    ('ValueError: two lines', "No module named 'exudyn'")
    """
    name, message = type(error).__name__, " ".join(str(error).split())
    text = message if isinstance(error, DriftformError | ImportError) else f"{name}: {message}"
    text = text if message else name
    frames = traceback.extract_tb(error.__traceback__) if with_place else []
    return f"{text} (in {frames[-1].name}, line {frames[-1].lineno})" if frames else text


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for a near miss, else the list of what is known.

    The result is appended to a message, so it starts with a separator and is never empty unless
    nothing is known.
    """
    names = sorted(set(known))
    close = get_close_matches(word, names, n=1, cutoff=0.6) or [n for n in names if n.lower() == word.lower()]
    if close:
        return f"; did you mean '{close[0]}'?"
    return f"; known: {', '.join(names)}" if names else ""
