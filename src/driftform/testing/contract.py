"""What all contracts share: a test that fails says what the contract asks, and answers depend on nothing but the question."""

import functools
import inspect
import pickle
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any, Generic, TypeAlias, TypeVar, cast

import pytest

from driftform.errors import DriftformError
from driftform.interfaces import Plugin
from driftform.types import same_content

PluginT_co = TypeVar("PluginT_co", covariant=True)

Question: TypeAlias = tuple[Any, ...]
"""A call of a plugin: the name of its method, and the arguments."""


def _explain(test: Callable[..., None]) -> Callable[..., None]:
    note = f"The contract asks: {' '.join((inspect.getdoc(test) or '').split())}"

    @functools.wraps(test)
    def explained(contract: Contract, *arguments: Any, **values: Any) -> None:
        __tracebackhide__ = True
        try:
            test(contract, *arguments, **values)
        except DriftformError as error:
            failure = AssertionError(str(error))
            failure.add_note(note)
            raise failure.with_traceback(error.__traceback__) from None
        except (Exception, pytest.fail.Exception) as error:
            error.add_note(note)
            raise

    return explained


class Contract:
    """Base class of all contracts: the failure of a test ends with the requirement that its docstring states."""

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


class AnsweringContract(SeamContract[PluginT_co]):
    """Base class of the contracts of seams whose plugins compute something: the same question has one answer."""

    def questions(self) -> Sequence[Question]:
        """Return calls that differ; their arguments can be pickled."""
        raise NotImplementedError

    def test_an_answer_depends_on_nothing_but_the_question(self) -> None:
        """A new instance, one that was asked other things before, and one in a new process give the same, to the last bit."""
        questions, asked = self.questions(), self.plugin()
        alone = [_answer(self.plugin(), [question])[0] for question in questions]
        self._compare(questions, alone, _answer(asked, questions[::-1])[::-1], "after other questions")
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            elsewhere = pool.submit(_answer, self.copy(), questions).result()
        self._compare(questions, alone, elsewhere, "in another process")

    def _compare(self, questions: Sequence[Question], answers: list[Any], others: list[Any], where: str) -> None:
        for (method, *_), answer, other in zip(questions, answers, others, strict=True):
            assert same_content(answer, other), f"{method}() answers differently {where}"


def _answer(plugin: object, questions: Sequence[Question]) -> list[Any]:
    """Return what a plugin answers to questions in this order; it receives copies of their arguments."""
    answers = []
    for question in questions:
        method, *arguments = pickle.loads(pickle.dumps(question))
        answers.append(getattr(plugin, method)(*arguments))
    return answers
