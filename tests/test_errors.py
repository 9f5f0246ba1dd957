"""Errors in one line, as failures of evaluations and messages to users show them."""

import pytest

from driftform.errors import DriftformError, InputError, describe_error


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (ValueError("first line\n  second line"), "ValueError: first line second line"),
        (ZeroDivisionError(), "ZeroDivisionError"),
        (ImportError("No module named 'exudyn'"), "No module named 'exudyn'"),
        (InputError("study.toml:3: unknown key 'sped'"), "study.toml:3: unknown key 'sped'"),
        (DriftformError(), "DriftformError"),
    ],
)
def test_an_error_is_described_in_one_line(error, line):
    assert describe_error(error) == line


def test_the_place_is_the_function_and_line_that_raised_the_error():
    def divide():
        return 1 / 0

    with pytest.raises(ZeroDivisionError) as caught:
        divide()
    line = divide.__code__.co_firstlineno + 1
    assert describe_error(caught.value, with_place=True) == (
        f"ZeroDivisionError: division by zero (in divide, line {line})"
    )


def test_a_notebook_shows_one_line_for_each_fault():
    error = InputError("a.toml:1: first", "a.toml:2: \x1b[2Jsecond")
    assert error._render_traceback_() == ["InputError: a.toml:1: first", "InputError: a.toml:2: \\x1b[2Jsecond"]
