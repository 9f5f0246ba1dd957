"""Compilation of kernels with numba; the machine code is cached on disk until any of their sources changes."""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

from numba import njit
from numba.extending import intrinsic

from driftform.types import FloatArray

P = ParamSpec("P")
R = TypeVar("R")


KERNELS = ("hydrodynamics", "dynamics", "trajectory")
"""The packages of the core that contain kernels."""


def _hash_sources() -> str:
    core = Path(__file__).parents[1]
    sources = [Path(__file__), *(file for name in KERNELS for file in sorted((core / name).glob("*.py")))]
    return hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()


_DIGEST = _hash_sources()


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function in numba's nopython mode, with its machine code cached on disk.

    numba's cache of a function depends only on the file of that function. After an upgrade, a kernel that calls a
    function of another file, or uses its constants, would silently keep their old code. Therefore the stamp of every
    cache file here covers all files of the packages with kernels. A version of numba without this stamp caches nothing.
    """
    dispatcher = njit(cache=True, nogil=True, error_model="numpy")(function)
    cache_file: Any = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if not hasattr(cache_file, "_source_stamp"):
        dispatcher = njit(nogil=True, error_model="numpy")(function)
    else:
        cache_file._source_stamp = (cache_file._source_stamp, _DIGEST)
    return dispatcher


def _borrow(_: Any, array: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = context.make_array(signature.return_type)(context, builder, arguments[0])
        view.meminfo = view.meminfo.type(None)
        return view._getvalue()

    return array(array), generate


borrow: Callable[[FloatArray], FloatArray] = cast(Any, intrinsic)(_borrow)
"""In kernels: return the same array without reference counting.

Reference counting is atomic, and takes half of the time of a kernel that reads many small arrays. The caller of the
kernel must keep the array alive.
"""
