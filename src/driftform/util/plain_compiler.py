"""numba's own compiler, by its public interface: kernels of all kinds count references, and are cached one by one."""

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import numba

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


@compile_kernel
def borrow(array: FloatArray, start: int, shape: tuple[int, ...]) -> FloatArray:
    """In kernels: return the numbers from an index on of an array in another shape, in the same memory."""
    size = 1
    for side in shape:
        size *= side
    return array.reshape(array.size)[start : start + size].reshape(shape)
