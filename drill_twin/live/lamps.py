# SPDX-License-Identifier: Apache-2.0
"""Severity of whirl, by the analyzer, and of stick-slip, by the bit's speed: 0 none, 1 moderate, 2 severe."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from drill_twin.whirl import BitMotion, MotionCode, StickSlip

SEVERE_RADIUS = 0.9
"""Radius of an orbit over its clearance from which a whirl is severe: the string is on the wall."""
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


def whirl_lamp(code: MotionCode, severity: float) -> Lamp:
    """Lamp of whirl.

    Args:
        code: Motion of the string.
        severity: Largest radius of an orbit over its clearance while the string whirls, in a vertical hole; else 0.
    """
    text, share = code.state.value, severity if severity > 0.0 else None
    if code is MotionCode.NOT_OBSERVABLE:
        return Lamp(None, text, None)
    if not code.whirls:
        return Lamp(0, text, None)
    return Lamp(2 if code is MotionCode.ROLLING or severity >= SEVERE_RADIUS else 1, text, share)


def stick_slip_lamp(bit: StickSlip) -> Lamp:
    """Lamp of stick-slip; not known during the start-up."""
    index = bit.index
    return Lamp(_BIT.get(bit.motion), bit.motion.value, index if math.isfinite(index) else None)
