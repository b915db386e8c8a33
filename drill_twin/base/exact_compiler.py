# SPDX-License-Identifier: Apache-2.0
"""Compiler pipelines of exact kernels: each part is optimised once, in the entry points that it is linked into.

LLVM may not change a result without fastmath, so it is the same, bit for bit, however often the code is optimised. The
entry points are called by address only: a wrapper for Python, which would unbox two hundred arrays, is left out.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering

from drill_twin.base.inlined_compiler import EntryCompiler, InlinedCompiler, InlinedLibrary, LoweringWithoutMachineCode

_LOWERING: Any = NativeLowering
_REGISTER: Any = register_pass


class LinkedLibrary(InlinedLibrary):
    """Code of a function and of what it calls, as lowered."""

    def _optimize_final_module(self) -> None:
        """No-op: the entry point's library optimises the whole."""

    def _finalize_final_module(self) -> None:
        """Make no machine code."""
        self._finalize_dynamic_globals()
        self._finalized = True


@_REGISTER(mutates_CFG=True, analysis_only=False)
class LoweringForLinking(LoweringWithoutMachineCode):
    """Lowering to LLVM's intermediate code, not optimised."""

    _name = "lowering_for_linking"
    library_class = LinkedLibrary


@_REGISTER(mutates_CFG=True, analysis_only=False)
class LoweringWithoutWrappers(_LOWERING):  # type: ignore[misc]
    """Lowering to machine code that is called by address; a call from Python raises TypeError."""

    _name = "lowering_without_wrappers"

    def run_pass(self, state: Any) -> bool:
        """Lower the function of a compiler state."""
        state.flags.no_compile = True
        state.flags.no_cpython_wrapper = True
        state.flags.no_cfunc_wrapper = True
        super().run_pass(state)
        result, library, context = state["cr"], state.library, state.targetctx
        module = library.create_ir_module("refusal")
        pointer = ir.IntType(8).as_pointer()
        kind = ir.FunctionType(pointer, [pointer] * 3)
        refusal = ir.Function(module, kind, result.fndesc.llvm_cpython_wrapper_name)
        builder = ir.IRBuilder(refusal.append_basic_block())
        python = context.get_python_api(builder)
        python.err_set_string("PyExc_TypeError", "called by address only")
        builder.ret(python.get_null_object())
        library.add_ir_module(module)
        entry = context.get_executable(library, result.fndesc, result.env)
        context.insert_user_function(entry, result.fndesc, [library])
        state.reload_init.extend(library._reload_init)  # noqa: SLF001 - as numba's own pass does
        state["cr"] = result._replace(cfunc=entry)
        return True


class LinkedCompiler(InlinedCompiler):
    """Pipeline of functions that only other kernels call."""

    lowering = LoweringForLinking


class AddressCompiler(EntryCompiler, InlinedCompiler):
    """Pipeline of entry points."""

    lowering = LoweringWithoutWrappers
    define_pipelines = InlinedCompiler.define_pipelines
