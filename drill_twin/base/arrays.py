# SPDX-License-Identifier: Apache-2.0
"""Short names for the types that kernels take."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bytes = NDArray[np.uint8]
Triple = tuple[float, float, float]
Pair = tuple[float, float]
