"""What the compiler of the kernels leaves out changes no result."""

import numpy as np
import pytest
from numba import njit
from numba.core.registry import cpu_target

from driftform.util.compiled import allocating, compiled

LAST, CORNER = -1, (1, -1)


@compiled
def read(values: np.ndarray, table: np.ndarray, i: int) -> tuple[float, ...]:
    return (
        values[0], values[-2], values[LAST], values[i], values[-i],
        table[1, 2], table[CORNER], table[i, 0], table[-1, -i], table[i][1], table[0, LAST],
    )  # fmt: skip


@compiled
def write(values: np.ndarray, table: np.ndarray, i: int) -> int:
    values[0], values[-2], values[LAST], values[i] = 1, 2.5, i, values[0] - values[i]
    table[CORNER] = 3.0
    table[i, 0] = table[-1, -i] = 4.0
    table[0][i] += 5.0
    table[0, 1] *= 2.0
    for k in range(-1, 2):
        table[k, 1] += k
    return 0


@pytest.fixture
def arrays():
    rng = np.random.default_rng(1)
    return rng.normal(size=6), rng.normal(size=(2, 3))


def call_part(kernel):
    """Return an entry that calls a kernel as its part."""

    @compiled
    def enter(values: np.ndarray, table: np.ndarray, i: int):
        return kernel(values, table, i)

    return enter


@pytest.mark.parametrize("layout", ["contiguous", "strided", "integers"])
@pytest.mark.parametrize("is_part", [False, True])
def test_elements_of_arrays_are_those_of_numpy(arrays, layout, is_part):
    values, table = arrays
    if layout == "strided":
        values, table = np.repeat(values, 2)[::2], np.asfortranarray(table)
    if layout == "integers":
        values, table = (100 * values).astype(np.int64), (100 * table).astype(np.int32)
    kernels = (call_part(read), call_part(write)) if is_part else (read, write)
    expected = values.copy(order="K"), table.copy(order="K")
    assert kernels[0](values, table, 1) == read.py_func(values, table, 1)
    kernels[1](values, table, 1)
    write.py_func(*expected, 1)
    assert np.array_equal(values, expected[0]) and np.array_equal(table, expected[1])


@compiled
def branch(x: float, n: int) -> float:
    total = 0.0
    for k in range(n):
        if x > k:
            step = x - k
        elif x < -k:
            step = k**2
        else:
            continue
        total += step * 2**k + x ** (-1)
        while step > 1.0:
            step /= 3.0
            total -= step
    return total


def test_variables_of_branches_and_loops_are_those_of_python():
    for x in (-3.5, 0.25, 2.5):
        assert branch(x, 6) == branch.py_func(x, 6)


@allocating
def double(values: np.ndarray) -> np.ndarray:
    result = np.empty_like(values)
    for k in range(values.shape[0]):
        result[k] = 2.0 * max(values[k], 0.0)
    return np.append(result, np.zeros(1))


def test_functions_that_are_no_kernels_share_what_numba_compiled_for_kernels(arrays):
    values, _ = arrays
    expected = np.append(2.0 * values.clip(min=0.0), 0.0)
    assert np.array_equal(double(values), expected)

    @njit
    def double_too(values):
        result = np.empty_like(values)
        for k in range(values.shape[0]):
            result[k] = 2.0 * max(values[k], 0.0)
        return np.append(result, np.zeros(1))

    assert np.array_equal(double_too(values), expected)

    @njit
    def fail(size):
        return np.empty(size)

    with pytest.raises(ValueError, match="negative dimensions"):
        fail(-1)


def test_numba_makes_its_own_libraries_after_a_kernel_is_compiled(arrays):
    codegen = cpu_target.target_context.codegen()
    usual = type(codegen)._library_class
    assert np.array_equal(double(arrays[0])[-1:], [0.0])
    assert codegen._library_class is usual

    @compiled
    def fail(a: str) -> float:
        return a.nothing

    with pytest.raises(Exception, match="nothing"):
        fail("x")
    assert codegen._library_class is usual
