"""How the kernels are compiled: by numba, once for each machine, and anew whenever any of their sources changes."""

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
"""The packages of the core that have kernels."""


def _hash_sources() -> str:
    core = Path(__file__).parents[1]
    sources = [Path(__file__), *(file for name in KERNELS for file in sorted((core / name).glob("*.py")))]
    return hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()


_DIGEST = _hash_sources()


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function in numba's nopython mode, with its machine code cached on disk.

    numba's cache of a function knows the function's own file alone. A kernel that calls one of another file, or
    uses its constants, would go on with their old code after an upgrade, silently. So the stamp of every cache
    file here covers all files of the packages with kernels; where numba has no such stamp any more, nothing is cached.
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
"""For kernels: the same array, to which no references are counted.

Counting them is atomic, and takes half of the time of a kernel that reads many small arrays. Whoever calls the kernel
keeps the array alive.
"""
