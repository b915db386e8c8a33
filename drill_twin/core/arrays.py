# SPDX-License-Identifier: Apache-2.0
"""Types of the arrays and tuples in signatures, and numbers that may be missing."""

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Mask = NDArray[np.bool_]
Bytes = NDArray[np.uint8]
Integers = NDArray[np.int64]
Triple = tuple[float, float, float]
Pair = tuple[float, float]


def number_or_nan(value: float | None) -> float:
    """The number, NaN for None."""
    return math.nan if value is None else float(value)


def number_or_none(value: float) -> float | None:
    """The number, None for NaN."""
    return None if math.isnan(value) else value
