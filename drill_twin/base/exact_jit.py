# SPDX-License-Identifier: Apache-2.0
"""Compiler flags of kernels whose results are those of numpy to the last bit: no sum is reordered, no product fused.

They allocate nothing, as those of the time loop (`drill_twin.base.jit`); an assignment of an array to a slice would.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drill_twin.base.exact_compiler import AddressCompiler, LinkedCompiler

Integers = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., Any])

FLAGS: dict[str, Any] = {"error_model": "numpy", "nogil": True, "_nrt": False}


def exact_kernel(function: Function) -> Function:
    """Compile a function that other kernels call, lazily."""
    return cast("Function", njit(**FLAGS, pipeline_class=LinkedCompiler)(function))


def exact_entry_kernel(function: Function) -> Function:
    """Compile an entry point that is called by its address, lazily."""
    return cast("Function", njit(**FLAGS, pipeline_class=AddressCompiler)(function))


@exact_kernel
def copy(values: NDArray[Any], out: NDArray[Any]) -> None:
    """Copy an array of one dimension."""
    for k in range(out.size):
        out[k] = values[k]
