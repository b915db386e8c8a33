# SPDX-License-Identifier: Apache-2.0
"""How every kernel is compiled: one decorator, so that the flags are chosen once.

* ``error_model="numpy"``: numba's default checks each division and blocks vectorisation (a factor 1.6 to 2 here).
* ``fastmath`` without ``nnan`` and ``ninf``: sums may be reordered and fused, yet a NaN stays a NaN, which the
  guard relies on.
* ``forceinline``: the pieces of the step share a few structures of arrays; passed to a real call, each array is seven
  words on the stack (measured: a third of the assembly's time).
* numba leaves LLVM's vectoriser of straight-line code off by default; the solver's and the element's rows need it.
* kernels release the GIL, so that a node answers services while the string moves.
* Nothing is cached here: numba's cache does not see edits in called functions. Only the composed entry point is
  cached, under a name made of all the sources it is built from (`drill_twin.solver.kernel_codegen`).
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import config, njit

config.SLP_VECTORIZE = 1  # type: ignore[attr-defined]

Function = TypeVar("Function", bound=Callable[..., Any])

FLAGS: dict[str, Any] = {
    "error_model": "numpy",
    "fastmath": {"reassoc", "contract", "arcp", "nsz", "afn"},
    "nogil": True,
    "forceinline": True,
}


def kernel(function: Function) -> Function:
    """Compile a function for the time loop (lazily, at its first call)."""
    return cast("Function", njit(**FLAGS)(function))
