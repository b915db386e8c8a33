# SPDX-License-Identifier: Apache-2.0
"""Problems of the motion of a run, by its severity and kind, from its summary."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drill_twin.core.severity import Bounds, Grade, Severity, told
from drill_twin.report.load_text import Summary, units_of
from drill_twin.whirl import BitMotion, MotionState

WHIRL, AXIAL, TORSION = "lateral motion", "axial motion", "torsion"
PROBLEMS = {
    WHIRL: ("lateral_rms", "lateral_peak", "bending_stress"),
    AXIAL: ("axial_rms", "axial_peak"),
    TORSION: ("stick_slip",),
}
"""Quantities of severity of each problem; the share that a repeat leaves is of the first one. The mean force of the
wall is of none: a string that lies still on the low side has it too."""


class Motion(NamedTuple):
    """Motion of a run, and how severe it is."""

    summary: Summary
    bounds: Bounds

    @property
    def whirls(self) -> bool:
        """True with an onset of whirl."""
        return self.summary["onset_s"] is not None

    @property
    def swings(self) -> bool:
        """True for a swing in a plane, which is no whirl."""
        return bool(self.summary["lasting_motion"] == MotionState.PLANE_SWING.value)

    @property
    def decays(self) -> bool:
        """True for a free swing of the bit that dies away."""
        return bool(self.summary["bit"] == BitMotion.DECAYING.value)

    def worst(self, problem: str) -> dict[str, Any] | None:
        """Entry of the quantity that decides (`core.severity.Severity.entry`); None where none is known."""
        rows = {key: row for key in PROBLEMS[problem] if (row := self.summary["severity_by_quantity"].get(key))}
        known = {
            key: Severity(Grade(row["grade"]), key, math.inf if row["value"] is None else row["value"], row["place"])
            for key, row in rows.items()
            if row["grade"] is not None
        }
        top = max(known.values(), default=None, key=lambda one: one.order(self.bounds))
        return top and {**top.entry, "why": rows[top.quantity].get("why", "")}

    def grade(self, problem: str) -> Grade:
        """Grade of a problem; none where it is not known."""
        top = self.worst(problem)
        return Grade(top["grade"]) if top else Grade.NONE

    def has(self, problem: str) -> bool:
        """True where the run has the problem: it whirls or swings, or its grade is medium or more."""
        kind = {WHIRL: self.whirls or self.swings, TORSION: self.decays}.get(problem, False)
        return kind or self.grade(problem) >= Grade.MEDIUM

    def size(self, problem: str) -> float:
        """Value of the first quantity of a problem [SI]; NaN where it is not known."""
        value = self.summary["severity_by_quantity"].get(PROBLEMS[problem][0], {}).get("value")
        return math.nan if value is None else float(value)

    def text(self, problem: str) -> str:
        """Grade and the quantity that decides it, such as `medium: lateral acceleration 2.6 g rms at mark_2`."""
        return told(self.worst(problem), units_of(self.summary))
