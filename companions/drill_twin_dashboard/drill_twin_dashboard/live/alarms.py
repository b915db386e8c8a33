# SPDX-License-Identifier: Apache-2.0
"""Alarms that are acknowledged, and the log of events; states as in ANSI/ISA-18.2.

An alarm is active from its cause to the end of it. It stays on the page until it is acknowledged and its cause is gone.
"""

from __future__ import annotations

import time as clock
from collections import deque
from dataclasses import asdict, dataclass
from typing import Any

from drill_twin.core.errors import DrillTwinError
from drill_twin.io.messages.diagnostics import Level
from drill_twin_dashboard.live.shown import short

_MOST_EVENTS, _RECENT = 1000, 8
_MOST_ALARMS = 100


@dataclass
class Alarm:
    """One alarm."""

    number: int
    """Number by which it is acknowledged."""
    text: str
    """Cause, as a sentence."""
    level: int
    """`Level.WARN` or `Level.ERROR`."""
    time: float | None
    """Simulated time of its cause [s]."""
    active: bool = True
    """The cause persists."""
    acknowledged: bool = False
    """A person has seen it."""


class Alarms:
    """Alarms by cause, and the log of what happened."""

    def __init__(self, *, recorded: bool) -> None:
        """Start empty; the events of a recording have no time of day."""
        self._recorded = recorded
        self._alarms: dict[str, Alarm] = {}
        self._events: deque[dict[str, Any]] = deque(maxlen=_MOST_EVENTS)
        self._count = 0

    def update(self, cause: str, level: int, text: str, time: float | None) -> bool:
        """Set the state of a cause: raised if it is new or worse than before, ended by `Level.OK`.

        Returns:
            True if it is raised or ended now, which is an event.
        """
        alarm = self._alarms.get(cause)
        if level == Level.OK:
            if alarm is None or not alarm.active:
                return False
            alarm.active = False
            self.note(f"over: {alarm.text}", time)
            self._forget(cause)
            return True
        if alarm is None or not alarm.active or level > alarm.level:
            if alarm is None and len(self._alarms) >= _MOST_ALARMS:
                return False
            self._alarms[cause] = Alarm(self.note(text, time, level), short(text), level, time)
            return True
        alarm.text = short(text)
        return False

    def acknowledge(self, number: int | None, time: float | None) -> None:
        """Acknowledge an alarm by its number, or all of them (None).

        Raises:
            DrillTwinError: There is none of that number.
        """
        found = {cause: alarm for cause, alarm in self._alarms.items() if number in {None, alarm.number}}
        if number is not None and not found:
            raise DrillTwinError(f"expected the number of an alarm, found {number}; it may be over")
        for cause, alarm in found.items():
            if not alarm.acknowledged:
                alarm.acknowledged = True
                self.note(f"acknowledged: {alarm.text}", time)
            self._forget(cause)

    def _forget(self, cause: str) -> None:
        if self._alarms[cause].acknowledged and not self._alarms[cause].active:
            del self._alarms[cause]

    def note(self, text: str, time: float | None, level: int = Level.OK) -> int:
        """Add an event to the log; returns its number."""
        self._count += 1
        told = "" if self._recorded else clock.strftime("%H:%M:%S")
        self._events.append(
            {"number": self._count, "time": time, "clock": told, "level": int(level), "text": short(text)}
        )
        return self._count

    def rows(self) -> list[dict[str, Any]]:
        """Alarms for JSON: those not acknowledged first, then the worst, then the newest."""
        order = sorted(self._alarms.values(), key=lambda alarm: (alarm.acknowledged, -alarm.level, -alarm.number))
        return [asdict(alarm) for alarm in order]

    def recent(self) -> list[dict[str, Any]]:
        """Newest events."""
        return list(self._events)[-_RECENT:]

    def events(self) -> list[dict[str, Any]]:
        """All events that are kept."""
        return list(self._events)
