# SPDX-License-Identifier: Apache-2.0
"""Compiler pipeline of functions that only other kernels call: typed and lowered, without wrappers or machine code.

numba gives every function a wrapper for Python, another for C, and machine code of its own. A kernel's functions are
inlined into one entry point, so all three are thrown away: without them the kernel of `pa6_bench` takes 0.56 of the
processor time to compile and comes out the same, bit for bit.
"""

from importlib import import_module
from typing import Any, cast

from numba import njit
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering

_DYNFUNC: Any = import_module("numba._dynfunc")
_LOWERING: Any = NativeLowering
_REGISTER: Any = register_pass


def _without_arguments() -> None:
    """Entry of inlined functions from Python: its argument count does not match, so a call raises TypeError."""


_NJIT: Any = njit
_INLINED_ONLY: Any = _NJIT(_without_arguments)


@_REGISTER(mutates_CFG=True, analysis_only=False)
class LoweringWithoutMachineCode(_LOWERING):  # type: ignore[misc]
    """Lowering to LLVM's intermediate code, registered with the target so that callers link and inline it."""

    _name = "lowering_without_machine_code"

    def run_pass(self, state: Any) -> bool:
        """Lower the function of a compiler state."""
        state.flags.no_compile = True
        state.flags.no_cpython_wrapper = True
        state.flags.no_cfunc_wrapper = True
        super().run_pass(state)
        result, library = state["cr"], state.library
        entry = _DYNFUNC.make_function(
            result.fndesc.lookup_module(),
            result.fndesc.qualname.rpartition(".")[2],
            "Inlined into kernels; call its py_func from Python.",
            _raising_entry(),
            result.env,
            (library,),
        )
        state.targetctx.insert_user_function(entry, result.fndesc, [library])
        state.reload_init.extend(library._reload_init)  # noqa: SLF001 - as numba's own pass does
        state["cr"] = result._replace(cfunc=entry)
        return True


class InlinedCompiler(CompilerBase):
    """numba's pipeline with the lowering replaced."""

    def define_pipelines(self) -> list[Any]:
        """The pipeline, as numba asks for it."""
        builder: Any = DefaultPassBuilder
        pipeline = builder.define_nopython_pipeline(self.state)
        pipeline.passes = [
            (LoweringWithoutMachineCode if step is NativeLowering else step, text) for step, text in pipeline.passes
        ]
        pipeline.finalize()
        return [pipeline]


def _raising_entry() -> int:
    """Address of a wrapper that raises TypeError whatever it is given."""
    _INLINED_ONLY.compile(())
    (compiled,) = _INLINED_ONLY.overloads.values()
    name = compiled.fndesc.llvm_cpython_wrapper_name
    return cast("int", compiled.library.get_pointer_to_function(name))
