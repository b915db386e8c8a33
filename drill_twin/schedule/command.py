# SPDX-License-Identifier: Apache-2.0
"""Set-points of the rig at one instant."""

import math
from dataclasses import dataclass

import numpy as np

from drill_twin.base.arrays import Array


@dataclass(frozen=True, slots=True)
class Command:
    """Set-points of the rig."""

    weight_on_bit: float
    """Weight on bit [N]; negative = tension."""
    rotation: float
    """Speed of the top drive [rad/s]; positive is right-handed about the upward axis."""
    block: float = 0.0
    """Speed of the travelling block [m/s], positive upwards; of a scene with `rig.block`."""

    def is_finite(self) -> bool:
        """Check that all set-points are finite numbers."""
        return math.isfinite(self.weight_on_bit) and math.isfinite(self.rotation) and math.isfinite(self.block)

    def array(self, size: int = 2) -> Array:
        """The first set-points as the time loop takes them, in the order of the fields; shape (size,)."""
        return np.array([self.weight_on_bit, self.rotation, self.block][:size])
