"""Compilation of kernels with numba; the machine code is cached on disk until any of their sources changes.

A kernel that is called from Python is an entry: it has a Python wrapper, and its machine code is cached, with that of
all kernels that it calls. A kernel that is called from another kernel is a part of it, and has neither: wrappers and
files for all parts took a third of the compilation.

Kernels count no references to arrays: their caller keeps every array alive. Counting is atomic, and took half of the time
of a flight. A kernel that makes arrays, or gets new ones from another kernel, counts them: it is `allocating`.
A kernel that returns arrays in the memory of others is `borrowing`.
"""

# Before numba is imported below.
import driftform.util.numba_alone  # noqa: F401

# isort: split
import gc
import hashlib
import multiprocessing
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from functools import cache, cached_property
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import numpy as np
from filelock import FileLock
from llvmlite.binding import add_symbol
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.cgutils import pack_array
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher
from numba.core.runtime._nrt_python import c_helpers
from numba.core.types import Array, Dispatcher, intp, unliteral
from numba.core.types.functions import BaseFunction
from numba.core.typing.typeof import _typeof_ndarray, typeof_impl
from numba.extending import intrinsic
from numba.np.numpy_support import from_dtype, map_layout

from driftform.types import FloatArray
from driftform.util import compiler
from driftform.util.compiler import EntryCompiler, PartCompiler, VectorizingCompiler
from driftform.util.preparation import preparing

P = ParamSpec("P")
R = TypeVar("R")


KERNELS = ("util", "water", "motion")
"""The packages of the core that contain kernels."""

COMPILATION_S = 10
"""Typical duration of the compilation for flights in the vertical plane, s."""

ANNOUNCED_S = 300.0
"""Time for which one announcement of the compilation serves all processes, s."""

_OPTIONS = {"nopython": True, "nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}


def _hash_sources() -> str:
    core = Path(__file__).parents[1]
    sources = [
        Path(__file__),
        Path(compiler.__file__),
        *(file for name in KERNELS for file in sorted((core / name).glob("*.py"))),
    ]
    return hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()


_DIGEST = _hash_sources()


@typeof_impl.register(np.ndarray)
def _type_of_array(array: Any, context: Any) -> Any:
    """Return numba's type of an array of numbers; numba itself imports ``numpy.ma`` to refuse the arrays of that."""
    if type(array) is not np.ndarray or array.dtype.kind not in "biufc":
        return _typeof_ndarray(array, context)  # type: ignore[no-untyped-call]
    return Array(from_dtype(array.dtype), array.ndim, map_layout(array), readonly=not array.flags.writeable)


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function in numba's nopython mode, with its machine code cached on disk if Python calls it.

    numba's cache of a function depends only on the file of that function. After an upgrade, a kernel that calls a
    function of another file, or uses its constants, would silently keep their old code. Therefore the stamp of every
    cache file here covers all files of the packages with kernels. A version of numba without this stamp caches nothing.
    """
    return cast(Callable[P, R], _Entry(function))


def allocating(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function as :func:`compiled` does, which makes arrays, or returns some, or calls one that returns some."""
    return cast(Callable[P, R], _Entry(function, allocates=True))


def borrowing(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function as :func:`compiled` does, which returns arrays, all of which it has from :data:`borrow`."""
    return cast(Callable[P, R], _Entry(function, borrows=True))


def vectorized(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function as :func:`allocating` does, with more optimization of it and of what it calls.

    For long loops of arithmetic, which then use instructions for several numbers at once.
    """
    return cast(Callable[P, R], _Entry(function, allocates=True, pipeline_class=VectorizingCompiler))


def find_code(function: Callable[P, R], *arguments: P.args, **_: P.kwargs) -> Callable[P, R]:
    """Return the machine code of a kernel for arguments of these types, which must be all that it has.

    Another function, or one with more arguments, is returned itself. A call takes 0.15 us less, because nothing looks at the types again.
    """
    if not isinstance(function, _Entry) or function.py_func.__code__.co_argcount != len(arguments):
        return function
    types = tuple(map(function.typeof_pyval, arguments))
    known = cast(Any, function.overloads).get(types)
    return cast(Callable[P, R], known.entry_point if known else function.compile(types))


@contextmanager
def _lock(path: Path) -> Iterator[None]:
    """Let one process at a time into this context; on a file system without locks, all of them."""
    lock = FileLock(path)
    with suppress(OSError, NotImplementedError):
        lock.acquire()
    try:
        yield
    finally:
        lock.release()


_RESOLVING = threading.RLock()


@contextmanager
def _resolve_calls_once() -> Iterator[None]:
    """Let numba remember which function a call with some types of arguments means.

    For every addition of two numbers it tries all functions of that name anew, from sets to dates, and calls of which it
    has seen the like are 97 % of all: this took a sixth of the compilation.
    """
    functions: Any = BaseFunction
    resolve = functions.get_call_type

    def resolve_once(function: Any, context: Any, args: Any, kws: Any) -> Any:
        if kws:
            return resolve(function, context, args, kws)
        known, call = vars(function).setdefault("_known_calls", {}), (context, tuple(args))
        if call not in known:
            known[call] = resolve(function, context, args, kws)
        return known[call]

    with _RESOLVING:
        functions.get_call_type = resolve_once
        try:
            yield
        finally:
            functions.get_call_type = resolve


@contextmanager
def _collect_later() -> Iterator[None]:
    """Let Python search for no unreachable objects: most that the compiler makes live on, and the search took 5 % of its time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


@cache
def _publish_runtime() -> None:
    """Tell numba's runtime to machine code that was loaded.

    numba does this too before it compiles, and then compiles what counts references, of which that code has its own copy.
    """
    for name, address in c_helpers.items():
        add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


class _Contents(CompileResultCacheImpl):
    """What the files of a cache hold: all but the environments of numba's own functions.

    Code needs its environment to print and to use Python's objects. Loading one imports its module: numba's for arrays
    imports those for texts, hashes and random numbers, which took a fifth of the time of loading all kernels.
    """

    def reduce(self, result: Any) -> Any:
        """Return what is written of a compiled kernel."""
        *parts, environments = super().reduce(result)  # type: ignore[no-untyped-call]
        return *parts, tuple(e for e in environments if e.consts or not _is_of_numba(e))


def _is_of_numba(environment: Any) -> bool:
    return bool(environment.globals["__name__"].startswith("numba."))


class _Cache(FunctionCache):
    """A cache whose files are valid for one state of all sources."""

    _impl_class = _Contents

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        self._cache_file._source_stamp = (self._cache_file._source_stamp, _DIGEST)

    def load_overload(self, sig: Any, context: Any) -> Any:
        """Load machine code, if there is any; numba's own method also prepares the compiler, for 0.4 s."""
        _publish_runtime()
        found = None
        try:
            found = self._load_overload(sig, context)  # type: ignore[no-untyped-call]
        except Exception:
            # A cache that cannot be read, such as one cut short by a power failure, is begun anew.
            with suppress(Exception):
                self.flush()  # type: ignore[no-untyped-call]
        if found is None:
            _announce()
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save machine code; a disk that refuses it, or an index that cannot be read, is no error."""
        # Processes that compile the kernel for other types of arguments write the same index.
        with suppress(Exception), _lock(Path(self.cache_path) / f"{self._py_func.__qualname__}.lock"):
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]


class _Part(CPUDispatcher):
    """A kernel as other kernels call it."""

    def __init__(self, function: Callable[..., Any], allocates: bool, borrows: bool) -> None:
        # numba's runtime counts the references; a part without this option would do as its caller does.
        options = {**_OPTIONS, "no_cpython_wrapper": True, "_nrt": allocates}
        super().__init__(function, targetoptions=options, pipeline_class=PartCompiler)
        self.borrows = borrows

    def add_overload(self, overload: Any) -> None:
        """Keep what was compiled for some types of arguments; refuse it if it would lose an array, or free it too early."""
        if not self.targetoptions["_nrt"]:
            _require_no_arrays(overload, self.borrows)
        super().add_overload(overload)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Take a literal for any number of its type: numba would compile the part for both."""
        return super().get_call_template(tuple(map(unliteral, args)), kws)


def _require_no_arrays(overload: Any, borrows: bool) -> None:
    """Raise TypeError if a kernel that counts no references returns arrays of its own, or calls a kernel that does."""
    types = overload.target_context.data_model_manager
    calls, typemap = overload.type_annotation.calltypes, overload.type_annotation.typemap
    returned = [] if borrows else [overload.signature.return_type]
    for call, signature in calls.items():
        kernel = typemap[call.func.name] if getattr(call, "op", "") == "call" else None
        if isinstance(kernel, Dispatcher) and not getattr(kernel.dispatcher, "borrows", False):
            returned.append(signature.return_type)
    if any(types[kind].contains_nrt_meminfo() for kind in returned):
        raise TypeError(
            f"{overload.fndesc.qualname}: a kernel that returns or receives new arrays must be @allocating"
        )


class _Entry(CPUDispatcher):
    """A kernel as Python calls it; kernels that call it are compiled with its part."""

    def __init__(
        self,
        function: Callable[..., Any],
        *_: object,
        allocates: bool = False,
        borrows: bool = False,
        pipeline_class: type[Compiler] = EntryCompiler,
    ) -> None:
        super().__init__(
            function, targetoptions={**_OPTIONS, "_nrt": allocates}, pipeline_class=pipeline_class
        )
        self._allocates, self._borrows = allocates, borrows

    def add_overload(self, overload: Any) -> None:
        """Keep what was compiled or loaded for some types of arguments; see :meth:`_Part.add_overload`."""
        if not self._allocates and hasattr(overload.type_annotation, "calltypes"):
            _require_no_arrays(overload, borrows=False)
        super().add_overload(overload)

    # Most kernels of a process are never called from Python, and their machine code is loaded with that of others: part
    # and cache are made when they are needed.

    @cached_property
    def _part(self) -> Any:
        return _Part(self.py_func, self._allocates, self._borrows)

    @cached_property
    def _has_cache(self) -> bool:
        """Open the cache; false if there is no directory that numba can write to."""
        with suppress(RuntimeError, AttributeError):
            self._cache = _Cache(self.py_func)
            return True
        return False

    def _lock(self, sig: Any) -> AbstractContextManager[object]:
        if not self._has_cache:
            return nullcontext()
        types = hashlib.sha256(str(sig).encode()).hexdigest()[:16]
        return _lock(Path(self._cache.cache_path) / f"{self.py_func.__qualname__}-{types}.lock")

    @property
    def _numba_type_(self) -> Any:
        return self._part._numba_type_

    def _compilation_chain_init_hook(self) -> None:
        """Load none of the extensions of numba that other packages bring: no kernel uses them."""

    def compile(self, sig: Any) -> Any:
        """Load or compile the kernel for some types of arguments, one process at a time.

        Others that need it wait, and load what that one compiled.
        """
        with preparing(), self._lock(sig), _resolve_calls_once(), _collect_later():
            return self._compile(sig)

    def _compile(self, sig: Any) -> Any:
        entry_point = super().compile(sig)
        for overload in cast(Any, self.overloads).values():
            for environment in overload._find_referenced_environments():
                overload.library.codegen.set_env(environment.env_name, environment)
        return entry_point


@cache
def _announce() -> None:
    """Print once that the compilation begins, unless the display of a run on a terminal shows it.

    A file beside the machine code of all packages keeps the other processes of the same run silent.
    """
    marker = Path(FunctionCache(_announce.__wrapped__).cache_path) / "kernels.announced"  # type: ignore[no-untyped-call]
    with suppress(OSError):
        if time.time() - marker.stat().st_mtime < ANNOUNCED_S:
            return
    with suppress(OSError):
        marker.parent.mkdir(parents=True, exist_ok=True)
        marker.touch()
    is_worker = multiprocessing.parent_process() is not None
    if not (is_worker and sys.stdout.isatty() and sys.stderr.isatty()):
        text = f"compiling the equations of motion, about {COMPILATION_S} s, once per machine"
        print(text, file=sys.stderr, flush=True)


def borrow_as(
    dtype: "np.dtype[Any] | None" = None,
) -> Callable[[FloatArray, int, tuple[int, ...]], Any]:
    """Return :data:`borrow`, which returns an array of this type: of records, for example."""

    def borrow(_: Any, array: Any, start: Any, shape: Any) -> Any:
        number = array.dtype if dtype is None else from_dtype(dtype)
        kind = array.copy(dtype=number, ndim=len(shape), layout="C")

        def generate(context: Any, builder: Any, __: Any, arguments: Any) -> Any:
            model, length = context.data_model_manager[kind], context.get_constant(intp, 1)
            given = context.data_model_manager[array].get(builder, arguments[0], "data")
            sides = [builder.extract_value(arguments[2], axis) for axis in range(kind.ndim)]
            item = context.get_data_type(number)
            size = context.get_constant(intp, context.get_abi_sizeof(item))
            strides = [size]
            for side in reversed(sides):
                strides.insert(0, builder.mul(strides[0], side))
                length = builder.mul(length, side)
            fields = {
                "nitems": length,
                "itemsize": size,
                "data": builder.bitcast(builder.gep(given, [arguments[1]]), item.as_pointer()),
                "shape": pack_array(builder, sides),  # type: ignore[no-untyped-call]
                "strides": pack_array(builder, strides[1:]),  # type: ignore[no-untyped-call]
            }
            view = model.get_value_type()(None)
            for name, field in fields.items():
                view = model.set(builder, view, field, name)
            return view

        return kind(array, intp, shape), generate

    return cast(Callable[..., Any], cast(Any, intrinsic)(borrow))


borrow: Callable[[FloatArray, int, tuple[int, ...]], FloatArray] = borrow_as()
"""In kernels: return the numbers from the index ``start`` on of an array (n,) as an array of this shape, in the same memory.

No references are counted to it and to its slices. The caller of the kernel must keep the array alive.
"""
