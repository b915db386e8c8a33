# SPDX-License-Identifier: Apache-2.0
"""Values of messages of unknown origin, as the page can show them."""

from __future__ import annotations

import math

from drill_twin.core.errors import printable
from drill_twin.dynamics.twin.frame import RigState


def short(text: str, most: int = 300) -> str:
    """Text of bounded length, without control characters."""
    return printable(text[:most], keep="")


def number(value: float) -> float | None:
    """Number for JSON, which has no NaN."""
    return float(value) if math.isfinite(value) else None


def rig_values(state: RigState) -> dict[str, float]:
    """Values of the rig by name [N, rev/s, N m, m/s]; no rate of penetration where the bit has not drilled."""
    return {
        "wob": state.bit_force,
        "rps": state.top_drive_speed / math.tau,
        "torque": state.top_drive_torque,
        "bit_rps": state.bit_speed / math.tau,
        "bit_torque": state.bit_torque,
        "hookload": state.hookload,
        "rop": state.rate_of_penetration if state.drilled > 0.0 else math.nan,
    }
