"""numba's compiler without what kernels do not need: it takes less than half the time.

A program for the processor is made of an entry, which Python calls, and its parts, the kernels that it calls. numba
optimizes and translates each function with all that it calls, and then optimizes and translates all of that again for
its caller. Here, a part and what numba itself adds (such as ``numpy.zeros``) stay apart until an entry links all of
them, optimizes them and translates them, once.
"""

import operator
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite import ir as llvm
from llvmlite.binding import Linkage, create_pass_builder, create_pipeline_tuning_options, parse_assembly
from numba.core import base, ir, typed_passes, types, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.imputils import user_function
from numba.core.ir_utils import get_definition, guard
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering

_UNUSED = {
    untyped_passes.WithLifting,
    untyped_passes.InlineClosureLikes,
    untyped_passes.RewriteDynamicRaises,
    untyped_passes.MakeFunctionToJitFunction,
    untyped_passes.InlineInlinables,
    untyped_passes.FindLiterallyCalls,
    untyped_passes.LiteralUnroll,
    untyped_passes.LiteralPropagationSubPipelinePass,
    typed_passes.InlineOverloads,
    typed_passes.NopythonRewrites,
    typed_passes.DumpParforDiagnostics,
}
"""Passes of numba for what no kernel has: closures, contexts, literals that unroll loops, expressions of whole arrays."""


class _PartLibrary(JITCodeLibrary):
    """The code of a part, in no form that a processor could run."""

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self._environments: dict[str, object] = {}
        self.raises = True

    def add_ir_module(self, ir_module: Any) -> None:
        """Add the function, and note whether it can return another status than 0, that of success."""
        if ir_module.name == "cfunc_wrapper":
            # A wrapper for callers in C, which numba writes for functions of its own.
            return
        ends = (block.terminator for function in ir_module.functions for block in function.blocks)
        statuses = [end.return_value for end in ends if isinstance(end, llvm.Ret)]
        self.raises = any(getattr(status, "constant", None) != 0 for status in statuses)
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


def _write_calls(fndesc: Any, libraries: Any) -> Any:
    """Return what writes the calls of a function, without a look at the status of a part that cannot raise an exception.

    numba writes 25 instructions around a call to pass exceptions on. Most functions raise none.
    """
    [library] = libraries
    if not isinstance(library, _PartLibrary) or library.raises:
        return user_function(fndesc, libraries)

    def write(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        function = context.declare_function(builder.module, fndesc)
        result, exception = function.args[:2]
        with builder.goto_entry_block():
            room = builder.alloca(result.type.pointee)
        flat = context.get_arg_packer(fndesc.argtypes).as_arguments(builder, arguments)
        builder.call(function, [room, exception.type(None), *flat])
        return context.get_returned_value(builder, fndesc.restype, builder.load(room))

    write.signature, write.libs = fndesc.argtypes, (library,)  # type: ignore[attr-defined]
    return write


class _KernelLower(Lower):
    """Writes the instructions of a kernel.

    numba clears variables when they are first and last used, calls a function for each access to an element of an array, and
    in it copies the array's description and corrects a negative index. Whatever changes nothing is not written here:
    most of the compilation is spent on moving these instructions, and then on removing them.
    """

    @property
    def _clears(self) -> bool:
        """True if variables must be cleared: references are counted, or a debugger sees them."""
        return bool(self.context.enable_nrt or self._disable_sroa_like_opt)

    def alloca_lltype(self, name: str, lltype: Any, datamodel: Any = None) -> Any:
        if self._clears:
            return super().alloca_lltype(name, lltype, datamodel)
        with self.builder.goto_entry_block():
            return self.builder.alloca(lltype, name=name)

    def storevar(self, value: Any, name: str, argidx: int | None = None) -> None:
        if self._clears:
            super().storevar(value, name, argidx)
        elif name in self._singly_assigned_vars:
            self._blk_local_varmap[name] = value
        else:
            self.builder.store(value, self.getvar(name))

    def delvar(self, name: str) -> None:
        if self._clears:
            super().delvar(name)
        elif name not in self._blk_local_varmap:
            self._singly_assigned_vars.discard(name)

    def lower_assign(self, ty: Any, inst: Any) -> Any:
        if isinstance(ty, types.Dispatcher) and isinstance(inst.value, ir.Global | ir.FreeVar):
            # Its type says which kernel is called; numba would also write and load the address of its object.
            return self.context.get_dummy_value()
        return super().lower_assign(ty, inst)

    def lower_binop(self, resty: Any, expr: Any, op: Any) -> Any:
        if op not in (operator.pow, operator.ipow):
            # Only powers have instructions of their own for constants; numba would try three of them for each operator.
            expr.static_lhs = expr.static_rhs = ir.UNDEFINED
        return super().lower_binop(resty, expr, op)

    def lower_expr(self, resty: Any, expr: Any) -> Any:
        if expr.op in ("getiter", "iternext") and self._counts_up(expr.value):
            value = self.loadvar(expr.value.name)
            return self._begin_count(value, resty) if expr.op == "getiter" else self._count(value, resty)
        return super().lower_expr(resty, expr)

    def _counts_up(self, value: Any) -> bool:
        """Return True for a range in steps of one, and for its iterator."""
        definition = guard(get_definition, self.func_ir, value)
        if getattr(definition, "op", "") == "getiter":
            definition = guard(get_definition, self.func_ir, definition.value)
        return (
            getattr(definition, "op", "") == "call"
            and len(definition.args) < 3
            and getattr(self.typeof(definition.func.name), "typing_key", None) is range
        )

    def _begin_count(self, value: Any, kind: Any) -> Any:
        """Return the iterator of such a range; numba would divide by its step, and look whether that is zero."""
        builder = self.builder
        start, stop, step = (builder.extract_value(value, k) for k in range(3))
        with builder.goto_entry_block():
            place, count = builder.alloca(start.type), builder.alloca(start.type)
        builder.store(start, place)
        builder.store(builder.sub(stop, start), count)
        iterator = llvm.Constant(self.context.get_value_type(kind), llvm.Undefined)
        for index, field in enumerate((place, stop, step, count)):
            iterator = builder.insert_value(iterator, field, index)
        return iterator

    def _count(self, value: Any, kind: Any) -> Any:
        """Return the next number, and whether it is in the range; numba would count what remains of the range as well."""
        builder = self.builder
        place, stop = builder.extract_value(value, 0), builder.extract_value(value, 1)
        number = builder.load(place)
        builder.store(builder.add(number, number.type(1)), place)
        pair = llvm.Constant(self.context.get_value_type(kind), llvm.Undefined)
        pair = builder.insert_value(pair, number, 0)
        return builder.insert_value(pair, builder.icmp_signed("<", number, stop), 1)

    def lower_getitem(self, resty: Any, expr: Any, value: Any, index: Any, signature: Any) -> Any:
        if not self._is_element(value, index):
            return super().lower_getitem(resty, expr, value, index, signature)
        kind = self.typeof(value.name).dtype
        item = self.context.unpack_value(self.builder, kind, self._point_to_element(value, index))
        return self.context.cast(self.builder, item, kind, resty)

    def lower_setitem(self, target: Any, index: Any, value: Any, signature: Any) -> Any:
        given = self.typeof(value.name)
        if not (isinstance(given, types.Number) and self._is_element(target, index)):
            return super().lower_setitem(target, index, value, signature)
        kind = self.typeof(target.name).dtype
        item = self.context.cast(self.builder, self.loadvar(value.name), given, kind)
        return self.context.pack_value(self.builder, kind, item, self._point_to_element(target, index))

    def _is_element(self, array: Any, index: Any) -> bool:
        """Return True if an index means one number of a contiguous array."""
        kind, places = self.typeof(array.name), self._list_places(index)
        return (
            isinstance(kind, types.Array)
            and isinstance(kind.dtype, types.Number)
            and (kind.layout, kind.aligned, kind.ndim) == ("C", True, len(places))
            and all(getattr(place, "signed", False) for place in places)
            and not self.context.enable_boundscheck
        )

    def _list_places(self, index: Any) -> tuple[Any, ...]:
        """Return the types of an index in each dimension."""
        kind = self.typeof(index.name)
        return tuple(getattr(kind, "types", (kind,)))

    def _point_to_element(self, array: Any, index: Any) -> Any:
        builder, places = self.builder, self._list_places(index)
        model = self.context.data_model_manager[self.typeof(array.name)]
        view, value = self.loadvar(array.name), self.loadvar(index.name)
        shape, data = map(model.get_field_position, ("shape", "data"))
        constants, offset = self._find_constants(index), None
        for axis, place in enumerate(places):
            number = (
                value
                if value.type == self.context.get_value_type(place)
                else builder.extract_value(value, axis)
            )
            number = self.context.cast(builder, number, place, types.intp)
            constant = constants[axis] if constants else getattr(place, "literal_value", -1)
            if constant >= 0:
                number = number.type(constant)
            else:
                end = builder.add(number, builder.extract_value(view, [shape, axis]))
                number = builder.select(builder.icmp_signed("<", number, number.type(0)), end, number)
            if offset is not None:
                number = builder.add(builder.mul(offset, builder.extract_value(view, [shape, axis])), number)
            offset = number
        return builder.gep(builder.extract_value(view, data), [offset])

    def _find_constants(self, index: Any) -> tuple[int, ...] | None:
        """Return an index that is a number or tuple of the source, or of its module; ``None`` for a computed one."""
        definition = guard(get_definition, self.func_ir, index)
        if not isinstance(definition, ir.Const | ir.Global | ir.FreeVar):
            return None
        return definition.value if isinstance(definition.value, tuple) else (definition.value,)


@register_pass(mutates_CFG=True, analysis_only=False)
class _KernelLowering(NativeLowering):
    _name = "kernel_lowering"

    @property
    def lowering_class(self) -> type[Lower]:
        return _KernelLower


class _KernelCompiler(Compiler):
    def define_pipelines(self) -> list[PassManager]:
        [manager] = super().define_pipelines()
        manager.passes = [
            (_KernelLowering if step is NativeLowering else step, description)
            for step, description in manager.passes
            if step not in _UNUSED
        ]
        manager.finalize()
        return [manager]


class PartCompiler(_KernelCompiler):
    """Compiles a part."""

    def __init__(self, typing: Any, target: Any, _: None, *rest: Any) -> None:
        super().__init__(typing, target, _PartLibrary(target.codegen(), "part"), *rest)


class _VectorizedLibrary(_EntryLibrary):
    """The code of an entry whose loops use instructions for several numbers at once."""

    _speed_level = 3


class EntryCompiler(_KernelCompiler):
    """Compiles an entry, and its parts with it."""

    _library: type[_EntryLibrary] = _EntryLibrary

    def __init__(self, typing: Any, target: Any, _: None, *rest: Any) -> None:
        library = self._library(target.codegen(), "entry")
        library.enable_object_caching()
        super().__init__(typing, target, library, *rest)

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile the entry, and whatever it calls, as parts."""
        with _make_parts(self.state.targetctx.codegen()):
            return super().compile_extra(func)


class VectorizingCompiler(EntryCompiler):
    """Compiles an entry whose loops use instructions for several numbers at once."""

    _library = _VectorizedLibrary


@contextmanager
def _make_parts(codegen: Any) -> Iterator[None]:
    """Let numba compile its own functions as parts; functions that are no kernels wait meanwhile."""
    context: Any = base
    with global_compiler_lock:
        codegen._library_class = _PartLibrary
        context.user_function = _write_calls
        try:
            yield
        finally:
            del codegen._library_class
            context.user_function = user_function
