"""The import of this module fails where the compiler of kernels does not work with the numba that is installed."""

import math
from types import FunctionType

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiler import borrow, borrow_as, compile_kernel

PAIR = np.dtype([("first", np.float64), ("second", np.float64)])


def _take_root(x: float) -> float:
    if x < 0.0:
        raise ValueError("negative")
    return math.sqrt(x)


def _halve(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    return borrow(values, 0, (2, 2)), borrow(values, 4, (4,))


def _mix(values: FloatArray, more: FloatArray | None) -> FloatArray:
    table, row = halve(values)
    out = np.zeros(4)
    for i in range(2):
        for j in range(-2, 0):
            out[2 * i + j] += table[i, j] * take_root(row[i - j]) / 3.0
    if more is not None:
        out[0] += more[-1] * borrow_pair(values, 6, (1,))[0].second
    return np.append(out, out[::2])


borrow_pair = borrow_as(PAIR)
take_root = compile_kernel(_take_root)
halve = compile_kernel(_halve, borrows=True)
_python = FunctionType(
    _mix.__code__,
    {
        "np": np,
        "take_root": _take_root,
        "halve": lambda values: (values[:4].reshape(2, 2), values[4:]),
        "borrow_pair": lambda values, start, _: values[start:].view(PAIR).view(np.recarray),
    },
)

_values, _more = np.arange(8.0) / 7.0, np.array([1.0, 2.0])
for _kind in ("new", "kept"):
    _kernel = compile_kernel(_mix, allocates=True)
    for _arguments in ((_values, None), (_values, _more), (_values[::2].repeat(2), _more)):
        if _kernel(*_arguments).tobytes() != _python(*_arguments).tobytes():
            raise ArithmeticError(f"{_kind} machine code gives other numbers than Python")
    try:
        _kernel(-_values, None)
    except ValueError:
        pass
    else:
        raise RuntimeError(f"{_kind} machine code raises no exception")
if not sum(_kernel.stats.cache_hits.values()):  # type: ignore[attr-defined]
    raise RuntimeError("machine code is not loaded")
