# SPDX-License-Identifier: Apache-2.0
"""Set-points of the rig at one instant: three values, of which a command may have a part."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array

QUANTITIES = {"weight on bit": ("weight_on_bit", "block"), "top-drive speed": ("rotation",)}
"""Quantities that may have a commander each, with the set-points that belong together."""


class Command(NamedTuple):
    """Set-points of the rig; NaN where a command has none.

    A command that is made from other commands is made by a method of this class. Code elsewhere that names single
    set-points would forget the set-points that are added later.
    """

    weight_on_bit: float
    """Weight on bit [N]; negative = tension."""
    rotation: float
    """Speed of the top drive [rad/s]; positive is right-handed about the upward axis."""
    block: float = 0.0
    """Speed of the travelling block [m/s], positive upwards; of a scene with `rig.block`."""

    def is_finite(self) -> bool:
        """Check that all set-points are finite numbers."""
        return all(map(math.isfinite, self))

    def array(self) -> Array:
        """The set-points as the time loop takes them, shape (3,)."""
        return np.array(self)

    def completed(self, other: Command) -> Command:
        """This command, with the set-points of another command where its own are not finite: NaN is no set-point."""
        return Command._make([own if math.isfinite(own) else spare for own, spare in zip(self, other, strict=True)])

    def mixed(self, other: Command, share: float) -> Command:
        """The command at a share of the way from this command to another."""
        return Command._make([own + share * (wanted - own) for own, wanted in zip(self, other, strict=True)])

    def part(self, names: Collection[str]) -> Command:
        """The set-points of these names alone."""
        named = zip(self._fields, self, strict=True)
        return Command._make([value if name in names else math.nan for name, value in named])
