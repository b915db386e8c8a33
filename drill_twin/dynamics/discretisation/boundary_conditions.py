# SPDX-License-Identifier: Apache-2.0
"""Boundary conditions of the string at bit and top."""

from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Mask
from drill_twin.scene import Scene

# Constrained unknowns of an end, by its key in the scene: x, y, z, x', y', z', psi.
BIT_ENDS = {
    "guided": (True, True, False, True, True, False, False),
    "pinned": (True, True, False, False, False, False, False),
    "sliding": (False, False, False, True, True, False, False),
    "free": (False, False, False, False, False, False, False),
    "stabilised": (False, False, False, False, False, False, False),
}
CLAMPED_TOP = (True, True, True, True, True, False, True)


class BoundaryConditions(NamedTuple):
    """Boundary conditions of bit and top that depend on rig and effects."""

    weight_at_top: bool
    """True if the weight on bit is set at the top, which is then free axially."""
    bit_on_rock: bool
    """True if an effect supports the bit of such a string; otherwise it is constrained axially."""
    torque_driven: bool
    """True if a torque drives the top; otherwise its rotation is prescribed."""
    hoisted: bool = False
    """True if the top hangs in the travelling block, free axially."""
    hinged: bool = False
    """True if the top may tilt."""

    @classmethod
    def of(cls, scene: Scene) -> "BoundaryConditions":
        """Boundary conditions of a scene."""
        weight_at_top = scene.rig.weight_on_bit.at == "top"
        hoisted = scene.rig.weight_on_bit.at == "block"
        bit_on_rock = (weight_at_top or hoisted) and bool(scene.effects.providing("weight"))
        return cls(
            weight_at_top,
            bit_on_rock,
            scene.rig.top_drive.model != "prescribed",
            hoisted,
            scene.string.top_end == "hinged",
        )

    def constrained(self, bit_end: str) -> Mask:
        """Mask of the constrained unknowns (r, r', psi) at bit and top, for `string.bit_end`; shape (2, 7)."""
        constrained = np.array([BIT_ENDS[bit_end], CLAMPED_TOP])
        if self.weight_at_top:
            constrained[0, 2], constrained[1, 2] = not self.bit_on_rock, False
        if self.hoisted:
            constrained[1, 2] = False
        if self.hinged:
            constrained[1, 3:5] = False
        constrained[1, 6] = not self.torque_driven
        return constrained
