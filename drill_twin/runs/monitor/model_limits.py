# SPDX-License-Identifier: Apache-2.0
"""Detection of effects that the scene leaves out although the motion needs them; for diagnostics and summary."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from drill_twin.dynamics.twin.frame import Frames, RigState
from drill_twin.physics.model.section_stress import LARGEST_STRESS
from drill_twin.scene import Scene

KEY = "left_out"
"""Key in the simulator's diagnostics; several sentences are joined by `SEPARATOR`."""
NOTES = "notes"
"""Key in the simulator's diagnostics for notes on the scene (`drill_twin.dynamics.discretisation.warnings`), joined
likewise."""
SEPARATOR = " | "
_BIT_FORCE = RigState._fields.index("bit_force")


def recorded_sentences(values: Mapping[str, str]) -> list[str]:
    """The sentences in the simulator's diagnostics: missing effects, and notes on the scene."""
    return [sentence for key in (KEY, NOTES) if values.get(key) for sentence in values[key].split(SEPARATOR)]


class MissingEffects:
    """Checks every frame for the first sign of a missing effect.

    Attributes:
        found: One sentence for each, with time and place, in order of appearance.
    """

    def __init__(self, scene: Scene) -> None:
        effects = scene.effects
        self.found: list[str] = []
        self._yielded: set[str] = set()
        self._check_wall = effects.wall is None
        block = effects.fatigue
        self._yield_strengths = {} if block is None else block.yield_strengths(scene)
        self._check_bit = scene.rig.weight_on_bit.at == "top" and not effects.providing("weight")

    def update(self, frames: Frames) -> None:
        """Check frames, in order."""
        force, depth = frames.rig[:, _BIT_FORCE], frames.wall_depth
        through, pulled = depth > 0.0, force < 0.0
        for k in np.flatnonzero(through | pulled | (frames.stress is not None)).tolist():
            if not (self._check_wall or self._check_bit or self._yield_strengths):
                return
            time = float(frames.time[k])
            if self._check_wall and through[k]:
                self._check_wall = False
                self.found.append(
                    f"at {time:.3f} s the string passed through the wall of the hole, {frames.wall_depth_at[k]:.3g} m "
                    "from the bit, and goes on as if there were none: list the effect `wall`"
                )
            if self._check_bit and pulled[k]:
                self._check_bit = False
                self.found.append(
                    f"at {time:.3f} s the bit was pulled with {-force[k]:.4g} N and would have lifted off "
                    "the bottom, which holds it here: list `rock_floor`, `bit_cutting` or `bit_regenerative`"
                )
            if frames.stress is not None:
                self._check_yield(time, frames.stress[k, :, LARGEST_STRESS].tolist())

    def _check_yield(self, time: float, largest: list[float]) -> None:
        """Check the stress of the sections of `fatigue` [Pa]."""
        for (name, strength), stress in zip(self._yield_strengths.items(), largest, strict=True):
            if stress > strength and name not in self._yielded:
                self._yielded.add(name)
                self.found.append(
                    f"at {time:.3f} s the stress at {name} reached {1e-6 * stress:.4g} MPa, above its yield strength "
                    f"of {1e-6 * strength:.4g} MPa, and goes on as if it were elastic: its damage counts for nothing"
                )

    def values(self) -> dict[str, str]:
        """Diagnostics values; empty while nothing is missing."""
        return {KEY: SEPARATOR.join(self.found)} if self.found else {}
