"""Results that are kept for the latest value."""

import numpy as np
import pytest

from driftform.util.latest import keep_latest


class Value:
    """Values that are all equal, so that only identity tells them apart."""

    def __init__(self, number):
        self.number = number

    def __eq__(self, other):
        return True

    __hash__ = None  # type: ignore[assignment]


def test_the_same_value_is_computed_once_and_an_equal_one_again():
    calls = []

    @keep_latest
    def double(value):
        calls.append(value)
        return np.array([2.0 * value.number])

    one, two = Value(1.0), Value(2.0)
    assert [double(v).item() for v in (one, one, two, two, one)] == [2.0, 2.0, 4.0, 4.0, 2.0]
    assert [value.number for value in calls] == [1.0, 2.0, 1.0]


def test_what_is_kept_cannot_be_changed():
    @keep_latest
    def double(value):
        return np.array([2.0 * value.number])

    with pytest.raises(ValueError, match="read-only"):
        double(Value(1.0))[0] = 3.0
