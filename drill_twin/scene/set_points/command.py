# SPDX-License-Identifier: Apache-2.0
"""Set-points of the rig at one instant: three values, which are taken, mixed and completed together only."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from drill_twin.core.arrays import Array


@dataclass(frozen=True, slots=True)
class Command:
    """Set-points of the rig.

    A command that is made from other commands is made by a method of this class. Code elsewhere that names single
    set-points would forget the set-points that are added later.
    """

    weight_on_bit: float
    """Weight on bit [N]; negative = tension."""
    rotation: float
    """Speed of the top drive [rad/s]; positive is right-handed about the upward axis."""
    block: float = 0.0
    """Speed of the travelling block [m/s], positive upwards; of a scene with `rig.block`."""

    @property
    def values(self) -> tuple[float, float, float]:
        """All set-points in the order of the fields, which arrays of set-points have too, shape (3,) or (F, 3)."""
        return self.weight_on_bit, self.rotation, self.block

    def is_finite(self) -> bool:
        """Check that all set-points are finite numbers."""
        return all(map(math.isfinite, self.values))

    def array(self) -> Array:
        """The set-points as the time loop takes them, shape (3,)."""
        return np.array(self.values)

    def completed(self, other: Self) -> Self:
        """This command, with the set-points of another command where its own are not finite: NaN is no set-point."""
        pairs = zip(self.values, other.values, strict=True)
        return type(self)(*(own if math.isfinite(own) else spare for own, spare in pairs))

    def mixed(self, other: Self, share: float) -> Self:
        """The command at a share of the way from this command to another."""
        pairs = zip(self.values, other.values, strict=True)
        return type(self)(*(own + share * (wanted - own) for own, wanted in pairs))

    def towards(self, target: Self, begun: Self, share: float) -> Self:
        """This command, each set-point moved to a target by at most a share of the way from `begun` to the target."""
        moved = []
        for own, wanted, start in zip(self.values, target.values, begun.values, strict=True):
            step = min(abs(share * (start - wanted)), abs(wanted - own))
            moved.append(own + math.copysign(step, wanted - own))
        return type(self)(*moved)
