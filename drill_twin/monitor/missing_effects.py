# SPDX-License-Identifier: Apache-2.0
"""What a run turned out to call for although its scene leaves it out; for diagnostics and summary."""

from __future__ import annotations

from collections.abc import Mapping

from drill_twin.scene import Scene
from drill_twin.twin.frame import Frame

KEY = "left_out"
"""Key in the simulator's diagnostics; several are set apart by `SEPARATOR`."""
SEPARATOR = " | "


def omissions_of(values: Mapping[str, str]) -> list[str]:
    """What the values of a simulator's diagnostics say was missing."""
    return values[KEY].split(SEPARATOR) if values.get(KEY) else []


class MissingEffects:
    """Looks at every frame for the first sign of an effect that is missing.

    Attributes:
        found: One sentence each, with time and place, in the order in which they showed.
    """

    def __init__(self, scene: Scene) -> None:
        effects = scene.effects
        self.found: list[str] = []
        self._watch_wall = effects.wall is None
        self._watch_bit = scene.rig.weight_on_bit.at == "top" and not effects.providing("weight")

    def look(self, frame: Frame) -> None:
        """Take in one frame."""
        if self._watch_wall and frame.wall_depth > 0.0:
            self._watch_wall = False
            self.found.append(
                f"at {frame.time:.3f} s the string passed through the wall of the hole, {frame.wall_depth_at:.3g} m "
                "from the bit, and goes on as if there were none: list the effect `wall`"
            )
        if self._watch_bit and frame.rig.bit_force < 0.0:
            self._watch_bit = False
            self.found.append(
                f"at {frame.time:.3f} s the bit was pulled with {-frame.rig.bit_force:.4g} N and would have lifted off "
                "the bottom, which holds it here: list `rock_floor` or `bit_cutting`"
            )

    def values(self) -> dict[str, str]:
        """For the diagnostics; empty while nothing is missing."""
        return {KEY: SEPARATOR.join(self.found)} if self.found else {}
