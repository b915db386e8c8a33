# SPDX-License-Identifier: Apache-2.0
"""Supervision of a run: trends, limits, alarms, the log of events, and a lamp each of whirl and stick-slip.

The analyzer tells the severity of whirl, and the speed of the bit tells the severity of stick-slip.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from drill_twin.core.errors import DrillTwinError
from drill_twin.io.messages.diagnostics import Level
from drill_twin.whirl import BitMotion, MotionCode, StickSlip
from drill_twin_dashboard.live.alarms import CHANNELS, SIDES, AlarmLimits, Alarms, Trends

SEVERE_RADIUS = 0.9
"""Radius of an orbit over its clearance from which a whirl is severe: the string is on the wall."""
_BIT = {BitMotion.AT_REST: 0, BitMotion.STEADY: 0, BitMotion.VIBRATION: 1, BitMotion.STICK_SLIP: 2, BitMotion.STANDS: 2}


class Lamp(NamedTuple):
    """Lamp of one kind of motion."""

    level: int | None
    """0 none, 1 moderate, 2 severe; None if the motion is not known."""
    text: str
    """The motion."""
    share: float | None
    """Largest radius of an orbit over its clearance; or the stick-slip index."""


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


_LIMITS = {f"{channel}_{side}" for channel in CHANNELS for side in SIDES}
_LEVELS = (Level.OK, Level.WARN, Level.ERROR)
UNKNOWN = Lamp(None, "unknown", None)
"""Lamp of a motion that nobody has told, or whose analyzer is gone."""


class Supervision:
    """Supervision of a run beyond its latest values."""

    def __init__(self, *, recorded: bool) -> None:
        """Start empty.

        Args:
            recorded: The trends of a recording are there from the start (`Trends.push`); a run's trends grow.
        """
        self.trends, self.alarms, self.limits = Trends(), Alarms(recorded=recorded), AlarmLimits()
        self._recorded = recorded
        self.time: float | None = None
        """Simulated time of the last rig state [s]."""
        self._bit = StickSlip()
        self._motions: dict[str, str] = {}
        self.lamps = {"whirl": UNKNOWN, "stick_slip": UNKNOWN}
        """Lamps by name."""

    def begin(self, name: str) -> None:
        """Begin a run of a scene."""
        self._bit, self.time = StickSlip(), None
        self.limits.again()
        self.lamps = dict.fromkeys(self.lamps, UNKNOWN)
        if not self._recorded:
            self._motions.clear()
            self.trends.clear()
            self.alarms.note(f"a run of {name} began", None)

    def rig(self, time: float, values: Mapping[str, float]) -> None:
        """Use the state of the rig at a time [s]."""
        if self.time is not None and time < self.time:
            self.limits.again()
            self._bit = StickSlip()
        self.time = time
        if not self._recorded:
            self.trends.push(time, values)
        self._bit.push(time, math.tau * values["bit_rps"], math.tau * values["rps"])
        self.light("stick_slip", stick_slip_lamp(self._bit))
        for cause, text, beyond in self.limits.check(time, values):
            self.alarms.update(cause, Level.ERROR if beyond else Level.OK, text, time)

    def light(self, name: str, lamp: Lamp) -> None:
        """Light a lamp, raise or end its alarm, and note a change of its motion."""
        self.lamps[name] = lamp
        said = f"{name.replace('_', '-')}: {lamp.text}"
        known = lamp.level is not None
        told = known and self.alarms.update(name, _LEVELS[lamp.level or 0], said, self.time)
        if not told and self._motions.get(name) != lamp.text:
            self.alarms.note(said, self.time)
        self._motions[name] = lamp.text

    def estimate(self, level: int, text: str) -> None:
        """Use the level and the sentence of the estimator; at an error, the model does not explain what is measured."""
        known = level if level in {Level.WARN, Level.ERROR} else Level.OK
        self.alarms.update("estimate", known, f"estimator: {text}", self.time)

    def nodes(self, rows: list[dict[str, Any]]) -> None:
        """Use the diagnostics of the nodes (`Sources.nodes`)."""
        for row in rows:
            bad = row["level"] == Level.ERROR
            text = f"{row['name']}: {row['text']}"
            self.alarms.update(f"node {row['name']}", Level.ERROR if bad else Level.OK, text, self.time)

    def take(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """Carry out what a request says about alarms and limits; returns the rest of it.

        Raises:
            DrillTwinError: There is no such alarm, or a limit is impossible.
        """
        rest = dict(request)
        if (number := rest.pop("acknowledge", None)) is not None:
            if number is False:
                raise DrillTwinError("expected the number of an alarm to acknowledge, or true for all, found false")
            self.alarms.acknowledge(None if number is True else int(number), self.time)
        for name in sorted(_LIMITS & rest.keys()):
            self.alarms.note(self.limits.set(name, rest.pop(name)), self.time)
        return rest

    def snapshot(self) -> dict[str, Any]:
        """Values for the page."""
        return {
            "lamps": {name: lamp._asdict() for name, lamp in self.lamps.items()},
            "alarms": self.alarms.rows(),
            "events": self.alarms.recent(),
            "limits": self.limits.values,
            "trends": self.trends.recent(),
        }

    def history(self) -> dict[str, Any]:
        """History that the page shows of the time before it was opened."""
        return {"trends": self.trends.all(), "events": self.alarms.events()}
