"""How numba compiles a kernel: with all it calls where Python enters, and nothing before it is needed.

numba by itself optimises every kernel together with all it calls, however far, emits machine code for it,
and does both again in every caller. Here a kernel that another kernel calls is only translated; what Python
calls is optimised with all it needs, and only that becomes machine code. Kernels with declared types
are compiled (or loaded from the cache) for a caller that is compiled: importing a file compiles nothing, and
a process whose entries are in the cache loads these alone.

The arithmetic is the same in every case: LLVM may not change the value of an operation on floats.
"""

from __future__ import annotations

import gc
from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

from llvmlite import binding, ir
from numba.core import caching, sigutils, typing
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher
from numba.core.targetconfig import ConfigStack

ENVIRONMENT = "_ZN08NumbaEnv"
"""What numba starts the names of variables with by which code finds its kernel's environment."""


class EntryCode(JITCodeLibrary):  # type: ignore[misc]
    """The code of a kernel that Python calls."""

    def _optimize_functions(self, module: Any) -> None:
        """Simplify functions one by one; numba prepares the passes for those that are only declared too."""
        module.data_layout = self._codegen._data_layout
        defined = [function for function in module.functions if not function.is_declaration]
        super()._optimize_functions(SimpleNamespace(functions=defined))


class InnerCode(EntryCode):
    """The code of a kernel that kernels call: what their code is linked with, and never machine code."""

    _final_module: Any

    def _optimize_functions(self, module: Any) -> None:
        """Leave it to the callers."""
        module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        """Leave it to the callers."""

    def _finalize_final_module(self) -> None:
        """Keep the code for the callers; numba makes ready to run what has its variables only."""
        shared = self._final_module
        variables = self._codegen._create_empty_module(self.name)
        for found in shared.global_variables:
            if found.name.startswith(ENVIRONMENT):
                pointer = ir.GlobalVariable(variables, ir.IntType(64), found.name)
                pointer.linkage, pointer.initializer = "common", ir.Constant(ir.IntType(64), 0)
        self._final_module = binding.parse_assembly(str(variables))
        super()._finalize_final_module()
        for function in shared.functions:
            if not function.is_declaration and function.linkage == binding.Linkage.external:
                function.linkage = "linkonce_odr"
        self._shared_module = shared


class Compilation:
    """What the kernels have in common that are compiled for one that Python calls.

    While it lasts nobody looks for garbage: a compiler makes many objects, and nearly all stay in use.
    numba compiles in one thread at a time.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._collected = False
        self._found: dict[Any, dict[Any, Any]] = {}

    def __enter__(self) -> None:
        if self._depth == 0:
            self._collected = gc.isenabled()
            gc.disable()
        self._depth += 1

    def __exit__(self, *error: object) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._found.clear()
            if self._collected:
                gc.enable()

    def found(self, flags: Any) -> dict[Any, Any]:
        """Return the signatures found so far for kernels that are compiled with these flags, by call."""
        return self._found.setdefault(flags, {})


COMPILATION = Compilation()


class CallTypes:
    """numba's typing context for one kernel, which finds the signature of equal calls once.

    numba asks again for every call of a kernel until no type changes, and for each of those that are alike.
    """

    def __init__(self, context: Any, found: dict[Any, Any]) -> None:
        self._context = context
        self._found = found

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """Return the signature of a call, or None."""
        call = func, args, tuple(kws.items())
        found = self._found.get(call)
        if found is None:
            found = self._found[call] = self._context.resolve_function_type(func, args, kws)
        return found


class EntryCompiler(Compiler):  # type: ignore[misc]
    """numba's compiler, with a library of ours."""

    code: type[EntryCode] = EntryCode

    def compile_extra(self, func: Any) -> Any:
        """Compile a function."""
        with COMPILATION:
            return super().compile_extra(func)

    def define_pipelines(self) -> Any:
        """Return numba's passes."""
        state = self.state
        state.library = self.code(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        flags = ConfigStack().top()
        # What numba compiles of its own for one kernel serves the others, with an entry or without.
        flags.no_cpython_wrapper = True
        state.typingctx = CallTypes(state.typingctx, COMPILATION.found(flags))
        return super().define_pipelines()


class InnerCompiler(EntryCompiler):
    """The compiler of kernels that kernels call."""

    code = InnerCode


class InnerFiles(caching.CompileResultCacheImpl):  # type: ignore[misc]
    """Names of files in the cache, apart from those of the same function with an entry."""

    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        """Return how the names of a function's files start."""
        return f"{super().get_filename_base(fullname, abiflags)}.inner"


class InnerCache(caching.FunctionCache):  # type: ignore[misc]
    """The cache of kernels that kernels call."""

    _impl_class = InnerFiles


class InnerKernel(CPUDispatcher):  # type: ignore[misc]
    """A kernel that kernels call, compiled for the declared types that a caller needs.

    Parameters
    ----------
    function
        What is compiled.
    signatures
        Declared types; none where those of each caller are taken.
    options
        As for ``numba.njit``.
    """

    def __init__(self, function: Any, signatures: Iterable[Any], options: dict[str, Any]) -> None:
        bare = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        super().__init__(function, targetoptions={**options, **bare}, pipeline_class=InnerCompiler)
        self._cache = InnerCache(function)
        pairs = map(sigutils.normalize_signature, signatures)
        self._declared = [typing.signature(result, *arguments) for arguments, result in pairs]

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return what numba types a call with; the one declared signature that it chooses is compiled."""
        if not self._declared:
            return super().get_call_template(args, kws)
        pysig, args = self._compiler.fold_argument_types(args, kws)
        name = self.py_func.__name__
        chosen = self.typingctx.resolve_overload(name, self._declared, args, {})
        if chosen is not None:
            self.compile(chosen)
        signatures = self._declared if chosen is None else [chosen]
        template = typing.make_concrete_template(f"CallTemplate({name})", key=name, signatures=signatures)
        return template, pysig, args, {}


class EntryKernel(CPUDispatcher):  # type: ignore[misc]
    """A kernel that Python calls, and kernels too: these get the code without the entry."""

    def __init__(self, function: Any, signatures: Iterable[Any], options: dict[str, Any]) -> None:
        called = {**options, "no_cfunc_wrapper": True}
        super().__init__(function, targetoptions=called, pipeline_class=EntryCompiler)
        self.enable_caching()
        self._inner = InnerKernel(function, signatures, options)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return what numba types a kernel's call with."""
        return self._inner.get_call_template(args, kws)

    def get_overload(self, sig: Any) -> Any:
        """Return what numba finds the code by that a kernel calls."""
        return self._inner.get_overload(sig)
