# SPDX-License-Identifier: Apache-2.0
"""Supervision of a run: trends, limits, alarms, the log of events, and a lamp each of whirl and stick-slip.

A lamp tells the motion; its colour and its alarm are of the severity: of the lateral acceleration, from the analyzer,
and of the rotation of the bit.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.severity import DEFAULT, Bounds, Grade, Severity, told
from drill_twin.core.units.system import SYSTEMS
from drill_twin.io.messages.diagnostics import Level
from drill_twin.whirl import StickSlip
from drill_twin.whirl.motion.stick_slip_index import TIME_BASE
from drill_twin.whirl.severity import torsion_grade, turns_backwards
from drill_twin_dashboard.live.alarms import LIMITS, AlarmLimits, Alarms, Trends

LEVELS = {Grade.NONE: 0, Grade.LOW: 0, Grade.MEDIUM: 1, Grade.HIGH: 2, Grade.SEVERE: 2}
"""Level of a lamp by its grade of severity: 1 is a warning, 2 an alarm."""


class Lamp(NamedTuple):
    """Lamp of one kind of motion."""

    level: int | None
    """0 none or low, 1 medium, 2 high or severe; None where the severity is not known."""
    text: str
    """The motion."""
    severity: str
    """Grade, and what decided it: `medium: lateral acceleration 2.6 g rms at mark_2`."""


def lamp(text: str, found: Severity | None) -> Lamp:
    """Lamp of a motion with its severity; None where it is not known."""
    if found is None:
        return Lamp(None, text, "severity unknown")
    return Lamp(LEVELS[found.grade], text, told(found.entry, SYSTEMS["si"]))  # accelerations are in g in all systems


def stick_slip_lamp(bit: StickSlip, bounds: Bounds = DEFAULT, *, backwards: bool = False) -> Lamp:
    """Lamp of the rotation of the bit, which turned `backwards` in the time of the index; not known while it starts."""
    grade = torsion_grade(bit.motion, bit.index, bounds, backwards=backwards)
    found = lamp(bit.motion.value, None if grade is None else Severity(grade, "stick_slip", bit.index))
    return found._replace(severity=f"{found.severity}, the bit turns backwards") if backwards and found.level else found


_RECENT = 8  # events in a snapshot
UNKNOWN = Lamp(None, "unknown", "")
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
        self._begin_motion()
        self.bounds = DEFAULT
        """Bounds of the grades of severity."""
        self._motions: dict[str, str] = {}
        self.lamps = {"whirl": UNKNOWN, "stick_slip": UNKNOWN}
        """Lamps by name."""

    def begin(self, name: str, bounds: Bounds = DEFAULT) -> None:
        """Begin a run of a scene, with its bounds of the grades of severity."""
        self.time, self.bounds = None, bounds
        self._begin_motion()
        self.lamps = dict.fromkeys(self.lamps, UNKNOWN)
        if not self._recorded:
            self._motions.clear()
            self.trends.clear()
            self.alarms.note(f"a run of {name} began", None)

    def _begin_motion(self) -> None:
        """Forget the bit, and what was beyond a limit."""
        self._bit, self._backwards = StickSlip(), -math.inf
        self.limits.again()

    def rig(self, time: float, values: Mapping[str, float]) -> None:
        """Use the state of the rig at a time [s]."""
        if self.time is not None and time < self.time:
            self._begin_motion()
        self.time = time
        if not self._recorded:
            self.trends.push(time, values)
        speeds = math.tau * values["bit_rps"], math.tau * values["rps"]
        self._bit.push(time, *speeds)
        if turns_backwards(*speeds):
            self._backwards = time
        backwards = time - self._backwards <= TIME_BASE
        self.light("stick_slip", stick_slip_lamp(self._bit, self.bounds, backwards=backwards))
        for cause, text, beyond in self.limits.check(time, values):
            self.alarms.update(cause, Level.ERROR if beyond else Level.OK, text, time)

    def light(self, name: str, lamp: Lamp) -> None:
        """Light a lamp, raise or end its alarm, and note a change of its motion."""
        self.lamps[name] = lamp
        said = f"{name.replace('_', '-')}: {lamp.text}" + f", {lamp.severity}" * bool(lamp.level)
        known = lamp.level is not None
        told = known and self.alarms.update(name, Level(lamp.level or 0), said, self.time)
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
            level = Level.ERROR if row["level"] == Level.ERROR else Level.OK
            self.alarms.update(f"node {row['name']}", level, f"{row['name']}: {row['text']}", self.time)

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
        for name in sorted(LIMITS.keys() & rest.keys()):
            self.alarms.note(self.limits.set(name, rest.pop(name)), self.time)
        return rest

    def snapshot(self) -> dict[str, Any]:
        """Values for the page."""
        return {
            "lamps": {name: lamp._asdict() for name, lamp in self.lamps.items()},
            "alarms": self.alarms.rows(),
            "events": list(self.alarms.events)[-_RECENT:],
            "limits": self.limits.values,
            "trends": self.trends.recent(),
        }

    def history(self) -> dict[str, Any]:
        """History that the page shows of the time before it was opened."""
        return {"trends": self.trends.all(), "events": list(self.alarms.events)}
