# SPDX-License-Identifier: Apache-2.0
"""Import of numba's array functions without scipy, which takes a fifth of the start of a short run.

On import they ask whether scipy's BLAS is there. Only functions that use it need to know, and those ask again when they
are compiled.
"""

from functools import cache
from importlib import import_module
from typing import Any


@cache
def import_array_functions() -> None:
    """Import `numba.np.arraymath`; later calls do nothing."""
    linalg: Any = import_module("numba.np.linalg")
    ensure_blas = getattr(linalg, "ensure_blas", _no_question)
    linalg.ensure_blas = _no_question
    try:
        import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = ensure_blas


def _no_question() -> None:
    """Stands in for `ensure_blas` during the import."""
