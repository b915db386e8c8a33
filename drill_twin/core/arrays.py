# SPDX-License-Identifier: Apache-2.0
"""Types of the arrays and tuples in signatures."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Mask = NDArray[np.bool_]
Bytes = NDArray[np.uint8]
Integers = NDArray[np.int64]
Triple = tuple[float, float, float]
Pair = tuple[float, float]
