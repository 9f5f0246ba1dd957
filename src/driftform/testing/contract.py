"""What all contracts share: a test that fails says what the contract asks."""

import functools
import inspect
from collections.abc import Callable
from typing import Any

import pytest

from driftform.errors import DriftformError


class Contract:
    """Base class of all contracts: the failure of a test ends with the requirement that its docstring states."""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        # Tests that a plugin adds are its own.
        if Contract in cls.__bases__:
            for name, test in list(vars(cls).items()):
                if name.startswith("test_"):
                    setattr(cls, name, _explain(test))


def _explain(test: Callable[..., None]) -> Callable[..., None]:
    note = f"The contract asks: {' '.join((inspect.getdoc(test) or '').split())}"

    @functools.wraps(test)
    def explained(*arguments: Any, **values: Any) -> None:
        __tracebackhide__ = True
        try:
            test(*arguments, **values)
        except DriftformError as error:
            failure = AssertionError(str(error))
            failure.add_note(note)
            raise failure.with_traceback(error.__traceback__) from None
        except (Exception, pytest.fail.Exception) as error:
            error.add_note(note)
            raise

    return explained
