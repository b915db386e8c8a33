# SPDX-License-Identifier: Apache-2.0
"""Trends of the channels, the limits that a person sets for them, alarms that are acknowledged, and the log of events.

An alarm is active from its cause to the end of the cause, and it stays on the page until it is acknowledged and its
cause is gone (states as in ANSI/ISA-18.2).
"""

import math
import time as clock
from collections import deque
from collections.abc import Iterator, Mapping
from itertools import takewhile
from typing import Any

import numpy as np

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.units import UnitError, parse
from drill_twin.core.units.dimension import ANGULAR_SPEED, FORCE, SPEED, TORQUE
from drill_twin.io.messages.diagnostics import Level
from drill_twin_dashboard.live.shown import short

CHANNELS = {
    "wob": ("weight on bit", FORCE), "rps": ("top-drive speed", ANGULAR_SPEED), "bit_rps": ("bit speed", ANGULAR_SPEED),
    "torque": ("top-drive torque", TORQUE), "hookload": ("hookload", FORCE), "rop": ("rate of penetration", SPEED),
}  # fmt: skip
"""Words and dimension of each channel; its values are in SI units, speeds of rotation in rev/s."""
SECONDS = 0.25
"""Length of an interval [s of simulated time]."""
_MOST = round(1800.0 / SECONDS)
_AGAIN = 8  # intervals sent twice, for a page that missed a snapshot


class Trends:
    """Intervals of one run; a row is its number, then least, mean and largest value of each channel."""

    def __init__(self, most: int = _MOST) -> None:
        self._rows: deque[list[float | None]] = deque(maxlen=most)
        self.run = -1
        """Number of the run; time that goes back begins another."""
        self.clear()

    def clear(self) -> None:
        """Begin another run."""
        self._rows.clear()
        self._begin(math.nan)
        self._sent = 0
        self.run += 1

    def _begin(self, place: float) -> None:
        """Begin an interval by its number; NaN: none."""
        self._present = place
        self._low = self._high = np.full(len(CHANNELS), math.nan)
        self._sum = self._counts = np.zeros(len(CHANNELS))

    def push(self, time: float, values: Mapping[str, float]) -> None:
        """Add the values of an instant [s]; a channel that is missing or not finite has no value."""
        place = math.floor(time / SECONDS + 1e-6)
        if place != self._present:
            if place < self._present:
                self.clear()
            else:
                self._close()
            self._begin(place)
        found = np.array([values.get(name, math.nan) for name in CHANNELS])
        found[np.isinf(found)] = math.nan
        self._low, self._high = np.fmin(self._low, found), np.fmax(self._high, found)
        self._sum, self._counts = self._sum + np.nan_to_num(found), self._counts + np.isfinite(found)

    def _close(self) -> None:
        if math.isnan(self._present):
            return
        row: list[float | None] = [self._present]
        for low, total, high, count in zip(self._low, self._sum, self._high, self._counts, strict=True):
            row += [float(f"{one:.6g}") for one in (low, total / count, high)] if count else [None, None, None]
        self._rows.append(row)

    def recent(self) -> dict[str, Any]:
        """Rows that are new since the last call, and a few before them."""
        first = self._sent - _AGAIN
        rows = list(takewhile(lambda row: (row[0] or 0) >= first, reversed(self._rows)))
        if self._rows:
            self._sent = int(self._rows[-1][0] or 0)
        return {"run": self.run, "rows": rows[::-1]}

    def all(self) -> dict[str, Any]:
        """All rows, with the names of the channels."""
        return {"run": self.run, "channels": list(CHANNELS), "seconds": SECONDS, "rows": list(self._rows)}


LIMITS = {f"{channel}_{side}": (channel, side) for channel in CHANNELS for side in ("low", "high")}
"""Channel and side of each limit, by its name."""
DELAY = 10.0
"""Time within a limit that ends an alarm [s of simulated time]: longer than a cycle of stick-slip or whirl."""


def parse_limit(text: str) -> dict[str, float]:
    """Name and value of a limit written as `torque_high=12 kN m`, for `AlarmLimits.set`.

    Raises:
        DrillTwinError: The text is no limit, or its value has no fitting unit.
    """
    name, _, value = (part.strip() for part in text.partition("="))
    if name not in LIMITS or not value:
        raise DrillTwinError(f'expected a limit as torque_high=12 kN m, of {", ".join(CHANNELS)}, found "{text[:100]}"')
    dimension = CHANNELS[LIMITS[name][0]][1]
    try:
        found = parse(value, dimension)
    except UnitError as error:
        raise DrillTwinError(f"limit {name}: {error}") from None
    return {name: found / math.tau if dimension is ANGULAR_SPEED else found}


class AlarmLimits:
    """Lowest and highest value of each channel [units of `CHANNELS`]."""

    def __init__(self) -> None:
        self.values: dict[str, dict[str, float]] = {}
        """Value by channel and side, `low` or `high`."""
        self._last: dict[str, float] = {}  # time at which a value was beyond, by name

    def set(self, name: str, value: float | bool) -> str:
        """Set a limit by its name, as `torque_high`, or remove it (False); returns a sentence for the log.

        Raises:
            DrillTwinError: The limit is True, or the lower one is not below the higher one.
        """
        channel, side = LIMITS[name]
        if value is True:
            raise DrillTwinError(f"expected a number as the limit {name}, or false for none, found true")
        own = {key: limit for key, limit in self.values.get(channel, {}).items() if key != side}
        if value is not False:
            own[side] = float(value)
        if len(own) == 2 and own["low"] >= own["high"]:
            raise DrillTwinError(
                f"expected a low limit of the {CHANNELS[channel][0]} below the high limit, found low at or above high"
            )
        self.values[channel] = own
        self._last.pop(name, None)
        return f"{'no limit' if value is False else 'limit set'}: {CHANNELS[channel][0]}, {side}"

    def again(self) -> None:
        """Forget what was beyond a limit: another run begins."""
        self._last.clear()

    def check(self, time: float, values: Mapping[str, float]) -> Iterator[tuple[str, str, bool]]:
        """Name and sentence of each limit; True from a value beyond it until no value was beyond it for `DELAY`."""
        for name, (channel, side) in LIMITS.items():
            limit, value = self.values.get(channel, {}).get(side), values.get(channel, math.nan)
            if limit is not None and (value < limit if side == "low" else value > limit):
                self._last[name] = time
            word = "below its low" if side == "low" else "above its high"
            beyond = time - self._last.get(name, -math.inf) < DELAY
            yield name, f"{CHANNELS[channel][0]} {word} limit", beyond


_MOST_EVENTS, _MOST_ALARMS = 1000, 100


class Alarms:
    """Alarms by cause, and the log of what happened.

    An alarm has its `number`, the `text` of its cause, its `level` (`Level.WARN` or `Level.ERROR`), the simulated
    `time` of the cause [s], and whether the cause is still `active` and a person has `acknowledged` the alarm.
    """

    def __init__(self, *, recorded: bool) -> None:
        """Start empty; the events of a recording have no time of day."""
        self._recorded = recorded
        self._alarms: dict[str, dict[str, Any]] = {}
        self.events: deque[dict[str, Any]] = deque(maxlen=_MOST_EVENTS)
        """Events that are kept, the newest last."""
        self._count = 0

    def update(self, cause: str, level: int, text: str, time: float | None) -> bool:
        """Set the state of a cause: its alarm is raised if it is new or worse than before, and ended by `Level.OK`.

        Returns:
            True if the alarm is raised or ended now, which is an event.
        """
        alarm = self._alarms.get(cause)
        if level == Level.OK:
            if alarm is None or not alarm["active"]:
                return False
            alarm["active"] = False
            self.note(f"over: {alarm['text']}", time)
            self._forget(cause)
            return True
        if alarm is None or not alarm["active"] or level > alarm["level"]:
            if alarm is None and len(self._alarms) >= _MOST_ALARMS:
                return False
            row = {"number": self.note(text, time, level), "text": short(text), "level": int(level), "time": time}
            self._alarms[cause] = {**row, "active": True, "acknowledged": False}
            return True
        alarm["text"] = short(text)
        return False

    def acknowledge(self, number: int | None, time: float | None) -> None:
        """Acknowledge an alarm by its number, or all of them (None).

        Raises:
            DrillTwinError: No alarm has the number.
        """
        found = {cause: alarm for cause, alarm in self._alarms.items() if number in {None, alarm["number"]}}
        if number is not None and not found:
            raise DrillTwinError(f"expected the number of an alarm, found {number}, whose alarm may be over")
        for cause, alarm in found.items():
            if not alarm["acknowledged"]:
                alarm["acknowledged"] = True
                self.note(f"acknowledged: {alarm['text']}", time)
            self._forget(cause)

    def _forget(self, cause: str) -> None:
        if self._alarms[cause]["acknowledged"] and not self._alarms[cause]["active"]:
            del self._alarms[cause]

    def note(self, text: str, time: float | None, level: int = Level.OK) -> int:
        """Add an event to the log; returns its number."""
        self._count += 1
        told = "" if self._recorded else clock.strftime("%H:%M:%S")
        self.events.append(
            {"number": self._count, "time": time, "clock": told, "level": int(level), "text": short(text)}
        )
        return self._count

    def rows(self) -> list[dict[str, Any]]:
        """Alarms for JSON: alarms not acknowledged first, then the worst, then the newest."""
        order = sorted(self._alarms.values(), key=lambda one: (one["acknowledged"], -one["level"], -one["number"]))
        return [dict(alarm) for alarm in order]
