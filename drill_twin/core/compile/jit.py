# SPDX-License-Identifier: Apache-2.0
"""Compiler flags of all kernels, applied by one decorator.

* ``error_model="numpy"``: numba's default checks each division and blocks vectorisation (a factor 1.6 to 2 here).
* ``fastmath`` without ``nnan`` and ``ninf``: sums may be reordered and fused, but a NaN stays a NaN, as the step
  guard requires.
* ``forceinline``: the functions of a step share structures of arrays; in a real call each array takes seven words on
  the stack (measured: a third of the assembly time).
* numba disables LLVM's superword-level vectoriser by default; the rows of solver and element need it.
* Kernels release the GIL, so that a node answers services during a step.
* No function of the time loop allocates, so none counts references (``_nrt``); an effect of another package may.
* numba is imported once a kernel is needed (`start`): a process that only reads or checks a scene does not import it.
* Nothing is cached here: numba's cache ignores edits in called functions. Only the generated entry points are cached,
  under a name derived from all of their sources (`drill_twin.core.compile.kernel_cache`).
"""

import re
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from threading import RLock
from types import CellType, FunctionType
from typing import Any, TypeVar, cast

from numpy.typing import NDArray

Function = TypeVar("Function", bound=Callable[..., Any])

FLAGS: dict[str, Any] = {
    "error_model": "numpy",
    "fastmath": {"reassoc", "contract", "arcp", "nsz", "afn"},
    "nogil": True,
    "forceinline": True,
}

_WAITING: dict[Callable[..., Any], Callable[[], Any]] = {}
"""Functions that were decorated before `start`, and what makes a dispatcher of each."""
_STARTED: list[bool] = []
_ONE_THREAD = RLock()

_WITHOUT_ALLOCATION = re.compile(r"drill_twin\.(core|physics|dynamics|whirl)\.|drill_twin_(kernel|linear|analysis)_")


def start() -> None:
    """Import numba, and put its dispatchers in the place of all functions that were decorated before."""
    with _ONE_THREAD:
        if not _STARTED:
            _start()
            _STARTED.append(True)


def _start() -> None:
    numba: Any = import_module("numba")
    numba.config.SLP_VECTORIZE = 1
    from drill_twin.core.compile import inlined_compiler  # noqa: F401  its source enters the names of kernels

    made = {function: make() for function, make in _WAITING.items()}
    for module in list(sys.modules.values()):
        for name, value in list(getattr(module, "__dict__", {}).items()):
            if type(value) is FunctionType and value in made:
                setattr(module, name, made[value])
    for cell in (cell for function in made for cell in function.__closure__ or ()):
        if type(bound := cell.cell_contents) is FunctionType:
            cell.cell_contents = made.get(bound, bound)
    _WAITING.clear()


def _compiled(function: Function, pipeline: str, **more: Any) -> Function:
    """The dispatcher of a function; before `start` the function itself, with a `py_func` as a dispatcher has."""
    flags = FLAGS | {"_nrt": not _WITHOUT_ALLOCATION.match(function.__module__)} | more

    def make() -> Function:
        compilers = import_module("drill_twin.core.compile.inlined_compiler")
        numba: Any = import_module("numba")
        return cast("Function", numba.njit(**flags, pipeline_class=getattr(compilers, pipeline))(function))

    with _ONE_THREAD:
        if _STARTED:
            return make()
        _WAITING[function] = make
        function.py_func = function  # type: ignore[attr-defined]
        return function


def kernel(function: Function) -> Function:
    """Compile a function that other kernels call, lazily; Python calls it through `as_python`."""
    return _compiled(function, "InlinedCompiler")


def entry_kernel(function: Function) -> Function:
    """Compile a function that Python calls, lazily."""
    return _compiled(function, "EntryCompiler")


def strict_kernel(function: Function) -> Function:
    """As `kernel`, without ``fastmath``: samples may be NaN, and `isfinite` computes x - x, which is then 0."""
    return _compiled(function, "InlinedCompiler", fastmath=False)


def strict_entry_kernel(function: Function) -> Function:
    """As `entry_kernel`, without ``fastmath``."""
    return _compiled(function, "EntryCompiler", fastmath=False)


@strict_kernel
def copy(values: NDArray[Any], out: NDArray[Any]) -> None:
    """Copy an array of one dimension; an assignment to a slice would allocate."""
    for k in range(out.size):
        out[k] = values[k]


@strict_kernel
def any_of(marks: NDArray[Any]) -> bool:
    """True where an array of one dimension holds a true value; numba's own imports scipy in each run."""
    found = False
    for k in range(marks.size):
        found = found or marks[k]
    return found


def is_inlined(dispatcher: Any) -> bool:
    """True for a compiled function that only other kernels call."""
    pipeline: type = dispatcher._compiler.pipeline_class  # noqa: SLF001
    return pipeline.__name__ == "InlinedCompiler"


@cache
def as_python(function: Any) -> Callable[..., Any]:
    """A kernel as Python, with all kernels that it calls: to call it outside of compiled code."""
    start()
    source, dispatcher = function.py_func, import_module("numba.core.dispatcher").Dispatcher
    known = {name: source.__globals__.get(name) for name in source.__code__.co_names}
    called = {  # `along` reads a field of its own name, and calls nothing of that name
        name: as_python(value)
        for name, value in known.items()
        if isinstance(value, dispatcher) and value.py_func is not source
    }
    named = {**source.__globals__, **called}
    bound = [cell.cell_contents for cell in source.__closure__ or ()]
    cells = tuple(CellType(as_python(value) if isinstance(value, dispatcher) else value) for value in bound)
    return FunctionType(source.__code__, named, source.__name__, source.__defaults__, cells)
