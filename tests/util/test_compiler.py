"""What the compiler of the kernels leaves out changes no result."""

import signal

import numpy as np
import pytest
from numba import njit
from numba.core.registry import cpu_target

from driftform.util.compiled import allocating, borrow, borrowing, compiled

LAST, CORNER = -1, (1, -1)


@compiled
def read(values, table, i):
    return (
        values[0], values[-2], values[LAST], values[i], values[-i],
        table[1, 2], table[CORNER], table[i, 0], table[-1, -i], table[i][1], table[0, LAST],
    )  # fmt: skip


@compiled
def write(values, table, i):
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
    def enter(values, table, i):
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
def branch(x, n):
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
def double(values):
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
    def fail(a):
        return a.nothing

    with pytest.raises(Exception, match="nothing"):
        fail("x")
    assert codegen._library_class is usual


@compiled
def visit(start, stop, step, out):
    count = 0
    for k in range(stop):
        out[count] = k
        count += 1
    for k in range(start, stop):
        for j in range(k):
            out[count] = 10 * k + j
            count += 1
    for k in range(start, stop, step):
        out[count] = -k
        count += 1
    return count


@pytest.mark.parametrize("limits", [(0, 3, 1), (1, 5, 2), (4, 1, -1), (2, -2, 1), (3, 3, -1)])
def test_ranges_are_those_of_python(limits):
    out, expected = np.zeros(40), np.zeros(40)
    assert visit(*limits, out) == visit.py_func(*limits, expected)
    assert np.array_equal(out, expected)


@compiled
def root(x):
    if x < 0.0:
        raise ValueError("negative")
    return x**0.5


@compiled
def sum_of_roots(values):
    total = 0.0
    for value in values:
        total += max(root(value), 1.0)
    return total


@compiled
def twice(values):
    return 2.0 * sum_of_roots(values)


def test_an_exception_passes_through_the_kernels_that_call_the_one_that_raises_it():
    assert twice(np.array([4.0, 0.0])) == 6.0
    with pytest.raises(ValueError, match="negative"):
        twice(np.array([4.0, -1.0]))
    assert twice(np.array([9.0])) == 6.0


@allocating
def spend(turns):
    values = np.zeros(3)
    for turn in range(turns):
        values[turn % 3] += 1.0 / (1.0 + values[(turn + 1) % 3])
    return values


@allocating
def spend_twice(turns):
    first = spend(turns)
    return first, 0.5, spend(turns)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timers that send signals")
@pytest.mark.parametrize("kernel", [spend, spend_twice])
def test_a_signal_while_a_kernel_runs_raises_what_its_handler_raises_once_the_kernel_has_returned(kernel):
    def stop(number, _):
        raise KeyboardInterrupt(number)

    kernel(1)
    before = signal.signal(signal.SIGALRM, stop)
    try:
        for _ in range(3):
            with pytest.raises(KeyboardInterrupt) as interruption:
                signal.setitimer(signal.ITIMER_REAL, 0.02)
                kernel(20_000_000)
            assert interruption.value.args == (signal.SIGALRM,)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    values = kernel(3)
    assert (values[0] if isinstance(values, tuple) else values).tolist() == [1.0, 1.0, 0.5]


@borrowing
def halves(values):
    n = values.shape[0] // 4
    return borrow(values, 0, (n, 2)), borrow(values, 2 * n, (n, 2, 1))


@allocating
def swap(values):
    a, b = halves(values)
    for i in range(a.shape[0]):
        for j in range(2):
            a[i, j], b[i, j, 0] = b[i, j, 0], a[i, j]
    return a[1].copy()


def test_borrowed_arrays_are_in_the_memory_of_the_array():
    values = np.arange(12.0)
    assert swap(values).tolist() == [8.0, 9.0]
    assert values.tolist() == [*range(6, 12), *range(6)]
