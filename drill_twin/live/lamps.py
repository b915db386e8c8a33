# SPDX-License-Identifier: Apache-2.0
"""Severity of whirl and of stick-slip, from the findings of the analyzer: 0 none, 1 moderate, 2 severe."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from drill_twin.whirl import BitMotion, MotionState
from drill_twin.whirl.motion.timeline import NO_WHIRL

SEVERE_RADIUS = 0.9
"""Radius of an orbit over its clearance from which a whirl is severe: the string is on the wall."""
_CALM = {state.value for state in NO_WHIRL}
_BIT = {BitMotion.STEADY.value: 0, BitMotion.VIBRATION.value: 1, BitMotion.STICK_SLIP.value: 2}


@dataclass(frozen=True)
class Lamp:
    """Lamp of one kind of motion."""

    level: int | None
    """0 none, 1 moderate, 2 severe; None if it is not known."""
    text: str
    """The motion."""
    share: float | None
    """Largest radius of an orbit over its clearance; or the stick-slip index of the last ten seconds."""

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def whirl_lamp(state: str, radius_share: float) -> Lamp:
    """Lamp of whirl.

    Args:
        state: Motion state of the string; empty if it is not known.
        radius_share: Largest radius of an orbit over its clearance; NaN if it is not known, or the string lies on the
            low side of the hole and is on the wall without whirl too.
    """
    share = radius_share if math.isfinite(radius_share) else None
    if not state or state == MotionState.NOT_OBSERVABLE.value:
        return Lamp(None, state or "unknown", share)
    if state in _CALM:
        return Lamp(0, state, share)
    return Lamp(2 if state == MotionState.ROLLING.value or (share or 0.0) >= SEVERE_RADIUS else 1, state, share)


def stick_slip_lamp(motion: str, index: float) -> Lamp:
    """Lamp of stick-slip.

    Args:
        motion: Motion of the bit, a value of `BitMotion`; empty if it is not known.
        index: (fastest - slowest) / (2 mean) of the bit's speed, the stick-slip index of Pavone and Desplans (1994).
    """
    return Lamp(_BIT.get(motion), motion or "unknown", index if math.isfinite(index) else None)
