# SPDX-License-Identifier: Apache-2.0
"""Compiler flags of kernels whose results are those of numpy to the last bit: no sum is reordered, no product fused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drill_twin.base.inlined_compiler import InlinedCompiler

Integers = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., Any])

FLAGS: dict[str, Any] = {"error_model": "numpy", "nogil": True}


def exact_kernel(function: Function) -> Function:
    """Compile a function that other kernels call, lazily."""
    return cast("Function", njit(**FLAGS, pipeline_class=InlinedCompiler)(function))


def exact_entry_kernel(function: Function) -> Function:
    """Compile a function that Python calls, lazily."""
    return cast("Function", njit(**FLAGS)(function))
