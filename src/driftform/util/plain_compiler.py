"""numba's own compiler, by its public interface: kernels of all kinds count references, and are cached one by one."""

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numpy as np

from driftform.types import FloatArray
from driftform.util.kernel_cache import announce, find_folder, use_folder
from driftform.util.preparation import preparing

P = ParamSpec("P")
R = TypeVar("R")

COMPILATION_S = 60
"""Typical duration of the compilation for flights in the vertical plane, s."""

FOLDER = find_folder("plain")
"""The folder of the machine code."""

_IS_NEW = not FOLDER.exists()


def compile_kernel(function: Callable[P, R], **_: bool) -> Callable[P, R]:
    """Compile a kernel of any kind."""
    try:
        with use_folder(FOLDER):
            kernel: Any = numba.njit(nogil=True, error_model="numpy", cache=True)(function)
    except RuntimeError:
        kernel = numba.njit(nogil=True, error_model="numpy")(function)
    compile_types = kernel.compile

    def compile_or_load(types: Any) -> Any:
        if _IS_NEW:
            announce(COMPILATION_S)
        with preparing():
            return compile_types(types)

    kernel.compile = compile_or_load
    return cast(Callable[P, R], kernel)


def borrow_as(dtype: "np.dtype[Any] | None" = None) -> Callable[[FloatArray, int, tuple[int, ...]], Any]:
    """Return :data:`borrow`, which returns an array of this type: of records, for example."""
    numbers = 1 if dtype is None else dtype.itemsize // 8

    @compile_kernel
    def borrow(array: FloatArray, start: int, shape: tuple[int, ...]) -> Any:
        size = numbers
        for side in shape:
            size *= side
        part = array.reshape(array.size)[start : start + size]
        # numba compiles no branch for what is None.
        return part.view(dtype).reshape(shape) if dtype is not None else part.reshape(shape)

    return borrow


borrow: Callable[[FloatArray, int, tuple[int, ...]], FloatArray] = borrow_as()
"""In kernels: return numbers of an array as an array of another shape, in the same memory."""
