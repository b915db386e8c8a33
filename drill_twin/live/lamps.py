# SPDX-License-Identifier: Apache-2.0
"""Severity of whirl, by the analyzer, and of stick-slip, by the bit's speed: 0 none, 1 moderate, 2 severe."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from drill_twin.whirl import BitMotion, MotionState, StickSlip
from drill_twin.whirl.motion.states import NO_WHIRL

SEVERE_RADIUS = 0.9
"""Radius of an orbit over its clearance from which a whirl is severe: the string is on the wall."""
_CALM = {state.value for state in NO_WHIRL}
_BIT = {BitMotion.AT_REST: 0, BitMotion.STEADY: 0, BitMotion.VIBRATION: 1, BitMotion.STICK_SLIP: 2, BitMotion.STANDS: 2}


@dataclass(frozen=True)
class Lamp:
    """Lamp of one kind of motion."""

    level: int | None
    """0 none, 1 moderate, 2 severe; None if it is not known."""
    text: str
    """The motion."""
    share: float | None
    """Largest radius of an orbit over its clearance; or the stick-slip index."""

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


def stick_slip_lamp(bit: StickSlip) -> Lamp:
    """Lamp of stick-slip; not known during the start-up."""
    index = bit.index
    return Lamp(_BIT.get(bit.motion), bit.motion.value, index if math.isfinite(index) else None)
