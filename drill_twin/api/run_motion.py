# SPDX-License-Identifier: Apache-2.0
"""Motion of a run with its severity by quantity, and the problems that it has."""

from __future__ import annotations

import math
from typing import NamedTuple

from drill_twin.core.severity import UNITS, WORDS, Bounds, Grade, Severity, grade, worst
from drill_twin.core.units.system import UnitSystem
from drill_twin.report.load_text import Summary
from drill_twin.whirl import BitMotion, MotionState

SWING = MotionState.PLANE_SWING.value
WHIRL, AXIAL, TORSION = "lateral motion", "axial motion", "torsion"
PROBLEMS = {
    WHIRL: ("lateral_rms", "lateral_peak", "bending_stress"),
    AXIAL: ("axial_rms", "axial_peak"),
    TORSION: ("stick_slip",),
}
"""Quantities of severity of each problem; the share that a repeat leaves is of the first one."""


class Motion(NamedTuple):
    """Motion of a run, and how severe it is."""

    summary: Summary
    severity: dict[str, Severity]
    """By quantity."""

    @property
    def whirls(self) -> bool:
        """True with an onset of whirl."""
        return self.summary["onset_s"] is not None

    def worst(self, problem: str) -> Severity | None:
        """Severity by the quantities of a problem; None where none is known."""
        known = (self.severity[key] for key in PROBLEMS[problem] if key in self.severity)
        return max(known, default=None, key=lambda one: one.grade)

    def grade(self, problem: str) -> Grade:
        """Grade of a problem; none where it is not known."""
        top = self.worst(problem)
        return top.grade if top else Grade.NONE

    def has(self, problem: str) -> bool:
        """True where the run has the problem: it whirls or swings, or its grade is medium or more."""
        swings = problem == WHIRL and (self.whirls or self.summary["lasting_motion"] == SWING)
        stuck = problem == TORSION and self.summary["bit"] == BitMotion.STANDS.value
        return swings or stuck or self.grade(problem) >= Grade.MEDIUM

    def size(self, problem: str) -> float:
        """Value of the first quantity of a problem [SI]; NaN where it is not known."""
        key = PROBLEMS[problem][0]
        return self.severity[key].value if key in self.severity else math.nan

    def text(self, problem: str, units: UnitSystem) -> str:
        """The worst quantity with its grade, such as `lateral acceleration, rms 2.6 g (medium)`."""
        if (top := self.worst(problem)) is None:
            return f"{problem} not known"
        size, unit = units.in_unit(UNITS[top.quantity])
        shown = f"{size * top.value:.2g}{'' if unit == '-' else f' {unit}'}"
        return f"{WORDS[top.quantity]} {shown} ({top.grade.word})"


def graded(summary: Summary, bounds: Bounds) -> dict[str, Severity]:
    """Severity by quantity of the run of a summary; a quantity that is not known is left out."""
    if (known := summary.get("severity_by_quantity")) is not None:
        return {
            key: Severity(Grade(one["grade"]), key, one["value"], one["place"])
            for key, one in known.items()
            if one is not None
        }
    index = summary["stick_slip_index"]
    found = [("stick_slip", math.nan if index is None else index, "")]
    for place, sizes in summary["acceleration"].items():
        found += [
            (f"{way}_{kind}", sizes[f"{way}_{kind}_m_s2"], place)
            for way in ("lateral", "axial")
            for kind in ("rms", "peak")
        ]
    return {
        key: top
        for key in Bounds._fields
        if (top := worst([one for one in found if one[0] == key and grade(*one[:2]) is not None], bounds))
    }
