"""What all contracts share: a test that fails says what the contract asks, and one that does not end fails."""

import functools
import inspect
import pickle
import threading
from collections.abc import Callable
from typing import Any, ClassVar, Generic, TypeVar, cast

import pytest

from driftform.errors import DriftformError
from driftform.interfaces import Plugin

PluginT_co = TypeVar("PluginT_co", covariant=True)


def _explain(test: Callable[..., None]) -> Callable[..., None]:
    note = f"The contract asks: {' '.join((inspect.getdoc(test) or '').split())}"

    @functools.wraps(test)
    def explained(contract: Contract, *arguments: Any, **values: Any) -> None:
        __tracebackhide__ = True
        try:
            _run_within(contract.time_limit, functools.partial(test, contract, *arguments, **values))
        except DriftformError as error:
            failure = AssertionError(str(error))
            failure.add_note(note)
            raise failure.with_traceback(error.__traceback__) from None
        except (Exception, pytest.fail.Exception) as error:
            error.add_note(note)
            raise

    return explained


def _run_within(seconds: float, test: Callable[[], None]) -> None:
    """Run a test, and fail if it takes longer; what hangs then stays in a thread that ends with the process."""
    __tracebackhide__ = True
    raised: list[BaseException] = []

    def run() -> None:
        try:
            test()
        except BaseException as error:
            raised.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(seconds)
    if thread.is_alive():
        pytest.fail(f"the test has not ended after {seconds:g} s; 'time_limit' of the class allows more")
    if raised:
        raise raised[0]


class Contract:
    """Base class of all contracts: the failure of a test ends with the requirement that its docstring states.

    Attributes:
        time_limit: time after which a test fails, s, with what the first flight compiles; a slower plugin raises it.
    """

    time_limit: ClassVar[float] = 300.0

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        # Tests that a plugin adds are its own.
        if cls.__module__.startswith(f"{__package__}."):
            for name, test in list(vars(cls).items()):
                if name.startswith("test_"):
                    setattr(cls, name, _explain(test))


class SeamContract(Contract, Generic[PluginT_co]):
    """Base class of the contracts of seams whose plugins are made from their options alone."""

    def plugin(self) -> PluginT_co:
        """Return the plugin to be tested."""
        raise NotImplementedError

    def copy(self) -> PluginT_co:
        """Return the plugin as a worker process receives it."""
        sent: PluginT_co = pickle.loads(pickle.dumps(self.plugin()))
        return sent

    def test_each_option_has_a_sentence_of_help(self) -> None:
        """Each field of ``Options`` is made with ``option``."""
        fields = cast("Plugin[Any]", self.plugin()).Options.model_fields
        assert [name for name, field in fields.items() if not field.description] == []
