"""numba's compiler without what kernels do not need: it takes a third of the time, and flights half of theirs.

A kernel that is called from Python is an entry: it has a Python wrapper, and its machine code is cached, with that of
all kernels that it calls. A kernel that is called from another kernel is a part of it, and has neither: wrappers and
files for all parts took a third of the compilation.

numba optimizes and translates each function with all that it calls, and then optimizes and translates all of that again for
its caller. Here, a part and what numba itself adds (such as ``numpy.zeros``) stay apart until an entry links all of
them, optimizes them and translates them, once.
"""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from copy import copy
from functools import cache, cached_property
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast
from zlib import crc32

import numpy as np
from llvmlite.binding import Linkage, add_symbol, create_pass_builder, create_pipeline_tuning_options, parse_assembly
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator
from numba.core.cgutils import pack_array
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.cpu import CPUContext
from numba.core.pythonapi import PythonAPI
from numba.core.registry import CPUDispatcher
from numba.core.runtime._nrt_python import c_helpers
from numba.core.serialize import dumps, loads
from numba.core.types import Dispatcher, intp, unliteral
from numba.extending import intrinsic
from numba.np.numpy_support import from_dtype

from driftform.types import FloatArray
from driftform.util.files import read_cached
from driftform.util.kernel_cache import announce, find_folder, hash_sources, lock
from driftform.util.preparation import preparing

P = ParamSpec("P")
R = TypeVar("R")

COMPILATION_S = 15
"""Typical duration of the compilation for flights in the vertical plane, s."""

FOLDER = find_folder("linked")
"""The folder of the machine code."""

_ARRAY_SYMBOL = "numpy.ndarray"
"""The class of arrays, as machine code names it."""

_OPTIONS = {"nopython": True, "nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}


class _PartLibrary(JITCodeLibrary):
    """The code of a part, in no form that a processor could run."""

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self._environments: dict[str, object] = {}

    def add_ir_module(self, ir_module: Any) -> None:
        """Add the function, and no wrapper for callers in C, which numba writes for functions of its own."""
        if ir_module.name != "cfunc_wrapper":
            super().add_ir_module(ir_module)

    @property
    def codegen(self) -> "_PartLibrary":
        """What registers the environment of the part: the entries that contain the part do so."""
        return self

    def set_env(self, name: str, environment: object) -> None:
        self._environments[name] = environment

    def get_pointer_to_function(self, name: str) -> int:
        self._ensure_finalized()
        return 0

    def finalize(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration:
                # Several parts may hold the same function of numba, such as one that makes the arguments of an exception.
                function.linkage = Linkage.weak_odr
        self._finalize_dynamic_globals()
        self._finalized = True

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout

    def _get_module_for_linking(self) -> Any:
        """Return what numba does for a function of its own: one that no kernel calls may share a helper with the kernels."""
        if self._shared_module is None:
            library = JITCodeLibrary(self._codegen, self.name)
            library._final_module.link_in(self._final_module, preserve=True)
            for function in library._final_module.functions:
                if not function.is_declaration:
                    function.linkage = Linkage.external
            library._linking_libraries = self._linking_libraries
            library.finalize()
            codegen: Any = self._codegen
            for name, environment in self._environments.items():
                codegen.set_env(name, environment)
            self._shared_module = library._get_module_for_linking()
        return self._shared_module


class _EntryLibrary(JITCodeLibrary):
    """The code of an entry, with that of all parts."""

    _speed_level = 1

    def finalize(self) -> None:
        own = {function.name for function in self._final_module.functions if not function.is_declaration}
        self._link_parts()
        # A function that nothing else can call may be inlined for good, and is passed only the arguments that it uses.
        for function in self._final_module.functions:
            if not function.is_declaration and function.name not in own:
                function.linkage = Linkage.internal
        super().finalize()

    def _link_parts(self) -> None:
        waiting, linked = self._linking_libraries, set()
        self._linking_libraries = []
        while waiting:
            library = waiting.pop()
            if library in linked:
                continue
            linked.add(library)
            if isinstance(library, _PartLibrary):
                self._final_module.link_in(library._final_module, preserve=True)
                waiting += library._linking_libraries
            else:
                self._linking_libraries.append(library)

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        # More optimization, such as copies of the bodies of loops, takes twice the time and makes no flight faster.
        tuning = create_pipeline_tuning_options(speed_level=self._speed_level)
        if self._speed_level == 1:
            tuning.loop_unrolling = tuning.loop_vectorization = tuning.slp_vectorization = False
        builder = create_pass_builder(self._codegen._tm, tuning)
        manager = builder.getModulePassManager()
        manager.add_refprune_pass()
        manager.run(self._final_module, builder)

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """Return the machine code, and the names in it: no library links an entry, which would need its instructions."""
        self._ensure_finalized()
        names = (f.name for f in self.get_defined_functions() if f.linkage != Linkage.internal)
        stubs = parse_assembly("\n".join(f'define void @"{name}"() {{ unreachable }}' for name in names))
        return self.name, "object", (self._get_compiled_object(), stubs.as_bitcode())


class _VectorizedLibrary(_EntryLibrary):
    """The code of an entry whose loops use instructions for several numbers at once."""

    _speed_level = 3


class _Wrapping(PythonAPI):
    """Writes the wrapper by which Python calls an entry, so that it runs no code in Python.

    numba's own looks up the class of each array that it returns by a function in Python. A signal that came while the
    kernel ran is handled there, and what its handler raises is lost: Ctrl-C would end in an error of the interpreter.
    """

    def serialize_object(self, obj: object) -> object:
        """Return what :meth:`unserialize` takes for an object."""
        return obj if obj is np.ndarray else super().serialize_object(obj)

    def unserialize(self, structptr: Any) -> Any:
        """Return the instructions that find an object."""
        return self.get_c_object(_ARRAY_SYMBOL) if structptr is np.ndarray else super().unserialize(structptr)


class _EntryContext(CPUContext):
    """What numba knows of the processor, and how Python calls entries."""

    def get_python_api(self, builder: Any) -> _Wrapping:
        return _Wrapping(self, builder)


class _PartCompiler(Compiler):
    """Compiles a part."""

    def __init__(self, typing: Any, target: Any, _: None, *rest: Any) -> None:
        super().__init__(typing, target, _PartLibrary(target.codegen(), "part"), *rest)


class _EntryCompiler(Compiler):
    """Compiles an entry, and its parts with it."""

    _library: type[_EntryLibrary] = _EntryLibrary

    def __init__(self, typing: Any, target: Any, _: None, *rest: Any) -> None:
        library = self._library(target.codegen(), "entry")
        library.enable_object_caching()
        # Only entries have wrappers; what else numba compiles keeps its own context.
        context = copy(target)
        context.__class__ = _EntryContext
        super().__init__(typing, context, library, *rest)

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile the entry, and the kernels that it calls as parts."""
        with _make_parts(self.state.targetctx.codegen()):
            return super().compile_extra(func)


class _VectorizingCompiler(_EntryCompiler):
    """Compiles an entry whose loops use instructions for several numbers at once."""

    _library = _VectorizedLibrary


@contextmanager
def _make_parts(codegen: Any) -> Iterator[None]:
    """Let numba compile its own functions as parts; functions that are no kernels wait meanwhile."""
    with global_compiler_lock:
        codegen._library_class = _PartLibrary
        try:
            yield
        finally:
            del codegen._library_class


@cache
def _publish_runtime() -> None:
    """Give machine code the addresses of the class of arrays and of numba's runtime.

    numba publishes its runtime too before it compiles, and then compiles what counts references, of which code that was
    loaded has its own copy.
    """
    add_symbol(_ARRAY_SYMBOL, id(np.ndarray))
    for name, address in c_helpers.items():
        add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


class _Place(_CacheLocator):
    """Where the machine code of a kernel is: a folder named by the content of the kernel's file, not by its path."""

    def __init__(self, function: Callable[..., Any], file: Path) -> None:
        self._folder, self._line = (
            FOLDER / f"{function.__module__}-{hash_sources([file])}",
            function.__code__.co_firstlineno,
        )

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> "_Place | None":
        """Return the place of a kernel; None, which raises RuntimeError, if it has no file or nothing can be written."""
        with suppress(OSError):
            place = cls(py_func, Path(py_file))
            place.ensure_cache_path()
            return place
        return None

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Return nothing: other sources have another folder."""
        return ""

    def get_disambiguator(self) -> str:
        return str(self._line)


class _Contents(CompileResultCacheImpl):
    """What the files of a cache hold: all but the environments of numba's own functions.

    Code needs its environment to print and to use Python's objects. Loading one imports its module: numba's for arrays
    imports those for texts, hashes and random numbers, which took a third of the time of loading all kernels.
    """

    _locator_classes = [_Place]  # noqa: RUF012 - as numba declares it

    def reduce(self, result: Any) -> Any:
        """Return what is written of a compiled kernel."""
        *parts, environments = super().reduce(result)
        content = dumps((*parts, tuple(e for e in environments if e.consts or not _is_of_numba(e))))
        return crc32(content), content

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        """Return a compiled kernel; a processor would run machine code that a disk altered."""
        if crc32(payload[1]) != payload[0]:
            raise ValueError("another checksum")
        return super().rebuild(target_context, loads(payload[1]))


def _is_of_numba(environment: Any) -> bool:
    return bool(environment.globals["__name__"].startswith("numba."))


class _Cache(FunctionCache):
    """A cache whose files are valid for one state of all sources."""

    _impl_class = _Contents

    def load_overload(self, sig: Any, context: Any) -> Any:
        """Load machine code, if there is any; numba's own method also prepares the compiler, for 0.8 s."""

        def load(_: Path) -> Any:
            try:
                return self._load_overload(sig, context)
            except Exception:
                with suppress(Exception):
                    self.flush()
                raise

        found = read_cached(Path(self._cache_file._index_path), load)
        if found is None:
            announce(COMPILATION_S)
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save machine code; ignore a disk that refuses it, and an index that cannot be read."""
        # Processes that compile the kernel for other types of arguments write the same index.
        with suppress(Exception), lock(Path(self.cache_path) / f"{self._py_func.__qualname__}.lock"):
            super().save_overload(sig, data)


class _Part(CPUDispatcher):
    """A kernel as other kernels call it."""

    def __init__(self, function: Callable[..., Any], allocates: bool, borrows: bool) -> None:
        # numba's runtime counts the references; a part without this option would do as its caller does.
        options = {**_OPTIONS, "no_cpython_wrapper": True, "_nrt": allocates}
        super().__init__(function, targetoptions=options, pipeline_class=_PartCompiler)
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
        raise TypeError(f"{overload.fndesc.qualname}: a kernel that returns or receives new arrays must be @allocating")


class _Entry(CPUDispatcher):
    """A kernel as Python calls it; kernels that call it are compiled with its part."""

    def __init__(self, function: Callable[..., Any], allocates: bool, borrows: bool, vectorizes: bool) -> None:
        super().__init__(
            function,
            targetoptions={**_OPTIONS, "_nrt": allocates},
            pipeline_class=_VectorizingCompiler if vectorizes else _EntryCompiler,
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
        """Open the cache; false if its folder cannot be written to."""
        with suppress(RuntimeError):
            self._cache = _Cache(self.py_func)
            return True
        return False

    def _lock(self, sig: Any) -> AbstractContextManager[object]:
        if not self._has_cache:
            return nullcontext()
        types = hashlib.sha256(str(sig).encode()).hexdigest()[:16]
        return lock(Path(self._cache.cache_path) / f"{self.py_func.__qualname__}-{types}.lock")

    @property
    def _numba_type_(self) -> Any:
        return self._part._numba_type_

    def _compilation_chain_init_hook(self) -> None:
        """Load none of the extensions of numba that other packages bring: no kernel uses them."""

    def compile(self, sig: Any) -> Any:
        """Load or compile the kernel for some types of arguments, one process at a time.

        Others that need it wait, and load what that one compiled.
        """
        _publish_runtime()
        with preparing(), self._lock(sig):
            entry_point = super().compile(sig)
            for overload in cast(Any, self.overloads).values():
                for environment in overload._find_referenced_environments():
                    overload.library.codegen.set_env(environment.env_name, environment)
            return entry_point


def compile_kernel(
    function: Callable[P, R], *, allocates: bool = False, borrows: bool = False, vectorizes: bool = False
) -> Callable[P, R]:
    """Compile a kernel; see the decorators in :mod:`driftform.util.compiled`."""
    return cast(Callable[P, R], _Entry(function, allocates, borrows, vectorizes))


def borrow_as(dtype: "np.dtype[Any] | None" = None) -> Callable[[FloatArray, int, tuple[int, ...]], Any]:
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
                "shape": pack_array(builder, sides),
                "strides": pack_array(builder, strides[1:]),
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
