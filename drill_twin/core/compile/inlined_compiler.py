# SPDX-License-Identifier: Apache-2.0
"""Compiler pipelines: of functions that only other kernels call, and of entry points.

numba gives every function a wrapper for Python, another for C, and machine code of its own. A kernel's functions are
inlined into one entry point, so all three are thrown away: the functions are typed and lowered as before, and end as
bitcode that is not optimised, which callers link. LLVM optimises the whole once, in the entry point. `pa6_bench` from
an empty cache: 42 s of processor time, and 56 s without the answers that `EntryCompiler` remembers and the short
symbols, with the same machine code.
"""

import gc
import hashlib
import inspect
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from importlib import import_module
from typing import Any, cast

from llvmlite import binding
from numba import njit
from numba.core import analysis, ir, types, typing
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompilerBase, DefaultPassBuilder, compile_result
from numba.core.compiler_machinery import register_pass
from numba.core.cpu import CPUContext
from numba.core.itanium_mangler import mangle
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering

_ANALYSIS: Any = analysis
_COMPILER: Any = Compiler
_CONSTANTS = (bool, int, float, str)
_DYNFUNC: Any = import_module("numba._dynfunc")
_IR: Any = ir
_LIBRARY: Any = JITCodeLibrary
_LOWER: Any = Lower
_LOWERING: Any = NativeLowering
_MANGLE: Any = mangle
_REGISTER: Any = register_pass
_TYPING: Any = typing
_ANSWERS: tuple[tuple[Any, str, int], ...] = (
    (types.Function, "get_call_type", 0),
    (_TYPING.Context, "resolve_function_type", 1),
    (CPUContext, "get_arg_packer", 1),
)
"""Class, method, and the first argument that its answer depends on; 0 is the object itself."""


def _without_arguments() -> None:
    """Entry of inlined functions from Python: its argument count does not match, so a call raises TypeError."""


_NJIT: Any = njit
_INLINED_ONLY: Any = _NJIT(_without_arguments)


class InlinedLibrary(_LIBRARY):  # type: ignore[misc]
    """Bitcode of a function and of what it calls, as lowered."""

    _final_module: Any

    def _optimize_final_module(self) -> None:
        """No-op: the entry point's library optimises the whole."""

    def _finalize_final_module(self) -> None:
        """Make no machine code."""
        self._finalize_dynamic_globals()
        self._finalized = True


class ValueLowering(_LOWER):  # type: ignore[misc]
    """Lowering in which a variable that is assigned once is a value, and has no place on the stack.

    numba does so only where all uses are in the block of the assignment. A record of arrays has hundreds of words,
    which LLVM would store, load and take apart at each use. Without reference counts nothing ends a variable.
    """

    def _find_singly_assigned_variable(self) -> None:
        """Add the variables whose one assignment is passed before each use."""
        super()._find_singly_assigned_variable()
        if self.context.enable_nrt:
            return
        blocks = self.blocks
        passed = _ANALYSIS.compute_cfg_from_blocks(blocks).dominators()
        assigned = [(one.target.name, at) for at, block in blocks.items() for one in block.find_insts(_IR.Assign)]
        count, place = Counter(name for name, _ in assigned), dict(assigned)
        for at, names in _ANALYSIS.compute_use_defs(blocks).usemap.items():  # where they are not assigned before
            count.update(name for name in names if not (place.get(name, at) < at and place[name] in passed[at]))
        once = {name for name in place if count[name] == 1} - _ANALYSIS.must_use_alloca(blocks)
        self._singly_assigned_vars |= once


@_REGISTER(mutates_CFG=True, analysis_only=False)
class LoweringWithoutMachineCode(_LOWERING):  # type: ignore[misc]
    """Lowering to LLVM's intermediate code, registered with the target so that callers link and inline it."""

    _name = "lowering_without_machine_code"
    lowering_class = ValueLowering

    def run_pass(self, state: Any) -> bool:
        """Lower the function of a compiler state."""
        state.flags.no_compile = True
        state.flags.no_cpython_wrapper = True
        state.flags.no_cfunc_wrapper = True
        state.library = InlinedLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        identity = state.func_id
        if name := lasting_name(identity.func):  # numba numbers the functions of a process: kept ones would clash
            identity.unique_id = _number(f"{name}({type_text(state.args)})")
        # Symbols with a number for the types: spelled out these take up to 250 000 letters. The context is a copy.
        state.targetctx.mangler = lambda name, kinds, **more: _MANGLE(name, [_number(type_text(kinds))], **more)
        super().run_pass(state)
        result, library = state["cr"], state.library
        library._ensure_finalized()  # noqa: SLF001 - as numba's own `get_executable` does
        entry = _entry(result.fndesc, result.env, library)
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
        lowering = LoweringWithoutMachineCode
        pipeline.passes = [(lowering if step is NativeLowering else step, text) for step, text in pipeline.passes]
        pipeline.finalize()
        return [pipeline]


class EntryCompiler(_COMPILER):  # type: ignore[misc]
    """numba's pipeline without collection of garbage, which remembers answers.

    A compiler makes millions of objects and keeps most of them. It resolves the types of 23 000 calls for `pa6_bench`,
    of which a thousand differ.
    """

    def compile_extra(self, func: Any) -> Any:
        """Compile a function, and all that it calls; numba's lock is held."""
        with ExitStack() as afterwards:
            if gc.isenabled():
                gc.disable()
                afterwards.callback(gc.enable)
            for owner, name, first in _ANSWERS:
                method = getattr(owner, name)
                setattr(owner, name, _remembered(method, first))
                afterwards.callback(setattr, owner, name, method)
            return super().compile_extra(func)


def _remembered(ask: Callable[..., Any], first: int) -> Callable[..., Any]:
    """A method that finds an answer once for the same arguments, from the first that counts; no error is kept."""
    known: dict[Any, Any] = {}

    def answer(*asked: Any) -> Any:
        try:
            key = tuple(tuple(one.items()) if type(one) is dict else one for one in asked[first:])
            found = known.get(key)
        except TypeError:  # a slice has no hash
            return ask(*asked)
        if found is None and (found := ask(*asked)) is not None:
            known[key] = found
        return found

    return answer


def inlined_parts(result: Any) -> tuple[Any, ...]:
    """Parts of the compilation of an inlined function from which it is restored, picklable."""
    description, library = result.fndesc, result.library
    description.typemap = description.calltypes = None
    bitcode = library._final_module.as_bitcode()  # noqa: SLF001 - as its `serialize_using_bitcode` does
    return library.name, bitcode, description, result.environment, result.signature, result.reload_init


def restore_inlined(target_context: Any, parts: tuple[Any, ...]) -> Any:
    """The compilation of an inlined function from what was kept of it."""
    name, bitcode, description, environment, signature, reload_init = parts
    for function in reload_init:
        function()
    library = InlinedLibrary(target_context.codegen(), name)
    library._final_module = binding.parse_bitcode(bitcode)  # noqa: SLF001 - as its `_unserialize` does
    library._finalized = True  # noqa: SLF001
    result: Any = compile_result
    return result(
        typing_context=target_context.typing_context,
        target_context=target_context,
        entry_point=_entry(description, environment, library),
        fndesc=description,
        library=library,
        environment=environment,
        signature=signature,
        reload_init=reload_init,
        objectmode=False,
        lifted=(),
    )


def lasting_name(function: Any) -> str:
    """Name that tells a function from all others in any process; "" for a function bound to more than constants.

    Functions that one source makes with other constants (`bind` of an effect) have the same name in Python.
    """
    name = f"{function.__module__}.{function.__qualname__}"
    if function.__closure__ is None:
        return name
    bound = [cell.cell_contents for cell in function.__closure__]
    return f"{name} {bound} {inspect.getsource(function)}" if all(type(one) in _CONSTANTS for one in bound) else ""


def type_text(argument_types: Any) -> str:
    """Types of arguments in words that tell named tuples of different classes or fields apart, as numba's do not."""
    found = []
    for one in argument_types:
        text = str(one)
        if (named := getattr(one, "instance_class", None)) is not None:
            fields = ", ".join(f"{name}: {type_text([part])}" for name, part in zip(named._fields, one, strict=True))
            text = f"{named.__module__}.{named.__qualname__}({fields})"
        found.append(text)
    return ", ".join(found)


def _number(text: str) -> int:
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big")


def _entry(description: Any, environment: Any, library: Any) -> Any:
    """The object through which numba knows a compiled function; a call from Python raises TypeError."""
    return _DYNFUNC.make_function(
        description.lookup_module(),
        description.qualname.rpartition(".")[2],
        "Inlined into kernels; call its py_func from Python.",
        _raising_entry(),
        environment,
        (library,),
    )


def _raising_entry() -> int:
    """Address of a wrapper that raises TypeError whatever it is given."""
    _INLINED_ONLY.compile(())
    (compiled,) = _INLINED_ONLY.overloads.values()
    name = compiled.fndesc.llvm_cpython_wrapper_name
    return cast("int", compiled.library.get_pointer_to_function(name))
