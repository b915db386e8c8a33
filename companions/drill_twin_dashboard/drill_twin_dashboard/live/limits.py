# SPDX-License-Identifier: Apache-2.0
"""Limits of the channels that a person has set, and whether values keep them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.units import UnitError, parse
from drill_twin.core.units.dimension import ANGULAR_SPEED, FORCE, SPEED, TORQUE
from drill_twin_dashboard.live.trends import CHANNELS

NAMES = {
    "wob": "weight on bit",
    "rps": "top-drive speed",
    "bit_rps": "bit speed",
    "torque": "top-drive torque",
    "hookload": "hookload",
    "rop": "rate of penetration",
}
"""Words for the channels."""
_DIMENSIONS = {
    "wob": FORCE, "rps": ANGULAR_SPEED, "bit_rps": ANGULAR_SPEED, "torque": TORQUE, "hookload": FORCE, "rop": SPEED
}  # fmt: skip
SIDES = ("low", "high")
DELAY = 10.0
"""Time within a limit that ends an alarm [s of simulated time]: longer than a cycle of stick-slip or whirl."""


def parse_limit(text: str) -> dict[str, float]:
    """Name and value of a limit written as `torque_high=12 kN m`, for `AlarmLimits.set`.

    Raises:
        DrillTwinError: It is none, or the value has no fitting unit.
    """
    name, _, value = (part.strip() for part in text.partition("="))
    channel = name.rpartition("_")[0]
    if channel not in _DIMENSIONS or not value:
        raise DrillTwinError(f"expected a limit as torque_high=12 kN m, of {', '.join(CHANNELS)}, found {text[:100]!r}")
    try:
        found = parse(value, _DIMENSIONS[channel])
    except UnitError as error:
        raise DrillTwinError(f"limit {name}: {error}") from None
    return {name: found / math.tau if _DIMENSIONS[channel] is ANGULAR_SPEED else found}


class AlarmLimits:
    """Lowest and highest value of each channel [units of `CHANNELS`]."""

    def __init__(self) -> None:
        self.values: dict[str, dict[str, float]] = {}
        """Value by channel and side, `low` or `high`."""
        self._last: dict[tuple[str, str], float] = {}  # time at which a value was beyond

    def set(self, name: str, value: float | bool) -> str:
        """Set a limit by its name, as `torque_high`, or remove it (False); returns a sentence for the log.

        Raises:
            DrillTwinError: There is no such limit, or the lower one is not below the higher one.
        """
        channel, _, side = name.rpartition("_")
        if channel not in CHANNELS or side not in SIDES or value is True:
            raise DrillTwinError(f"expected a limit CHANNEL_low or CHANNEL_high of {', '.join(CHANNELS)}, found {name}")
        own = {key: limit for key, limit in self.values.get(channel, {}).items() if key != side}
        if value is not False:
            own[side] = float(value)
        if len(own) == len(SIDES) and own["low"] >= own["high"]:
            raise DrillTwinError(f"expected a low limit of the {NAMES[channel]} below the high one, found it above")
        self.values[channel] = own
        self._last.pop((channel, side), None)
        return f"limit set: {NAMES[channel]}, {side}" if value is not False else f"no limit: {NAMES[channel]}, {side}"

    def again(self) -> None:
        """Forget what was beyond a limit: another run begins."""
        self._last.clear()

    def check(self, time: float, values: Mapping[str, float]) -> Iterator[tuple[str, str, bool]]:
        """Name, sentence and state of each limit: beyond as soon as a value is, until none was for `DELAY`."""
        for channel in CHANNELS:
            for side in SIDES:
                key = channel, side
                limit, value = self.values.get(channel, {}).get(side), values.get(channel, math.nan)
                if limit is not None and (value < limit if side == "low" else value > limit):
                    self._last[key] = time
                word = "below its low" if side == "low" else "above its high"
                beyond = time - self._last.get(key, -math.inf) < DELAY
                yield f"{channel}_{side}", f"{NAMES[channel]} {word} limit", beyond
