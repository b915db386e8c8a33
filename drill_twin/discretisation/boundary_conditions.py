# SPDX-License-Identifier: Apache-2.0
"""How the two ends of a string are held and driven."""

from typing import NamedTuple

import numpy as np

from drill_twin.base.arrays import Mask
from drill_twin.scene import Scene

# Which of (r, r', psi) an end holds: x, y, z, x', y', z', psi.
BIT_ENDS = {
    "guided": (True, True, False, True, True, False, False),
    "pinned": (True, True, False, False, False, False, False),
    "sliding": (False, False, False, True, True, False, False),
    "free": (False, False, False, False, False, False, False),
    "stabilised": (False, False, False, False, False, False, False),
}
CLAMPED_TOP = (True, True, True, True, True, False, True)


class Ends(NamedTuple):
    """What holds, loads and turns the bit and the top."""

    from_top: bool
    """Whether the weight on bit is set at the top, which then moves up and down."""
    on_rock: bool
    """Whether an effect carries the bit of such a string; without one it is held."""
    driven: bool
    """Whether a torque turns the top; otherwise its turn is prescribed."""

    @classmethod
    def of(cls, scene: Scene) -> "Ends":
        """The ends of a scene's string."""
        from_top = scene.rig.weight_on_bit.at == "top"
        on_rock = from_top and bool(scene.effects.providing("weight"))
        return cls(from_top, on_rock, scene.rig.top_drive.model != "prescribed")

    def held(self, bit_end: str) -> Mask:
        """Which of (r, r', psi) are held at the bit, its end as in the scene, and at the top; shape (2, 7)."""
        held = np.array([BIT_ENDS[bit_end], CLAMPED_TOP])
        if self.from_top:
            held[0, 2], held[1, 2] = not self.on_rock, False
        held[1, 6] = not self.driven
        return held
