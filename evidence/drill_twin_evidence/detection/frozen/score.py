# SPDX-License-Identifier: Apache-2.0
"""Score of any detector on the frozen records."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.whirl import Analyzer, MotionPeriod, Summary
from drill_twin.whirl.criteria import ONSET_RADIUS
from drill_twin_evidence.detection.frozen.truth import (
    BACKWARD,
    BENDING,
    FIXED,
    FORWARD,
    IRREGULAR,
    NEW,
    ROLLING,
    SPIRAL,
    SYNCHRONOUS,
    FrozenRecord,
    Truth,
)  # fmt: skip

STATES = (
    FIXED, SYNCHRONOUS, FORWARD, BACKWARD, ROLLING, BENDING, SPIRAL, IRREGULAR, *NEW, "at rest", "not observable",
)  # fmt: skip
"""Motion states in the order of the confusion matrix."""


@dataclass(frozen=True)
class Finding:
    """Findings of a detector for a record."""

    onset: float | None
    """Time of the onset [s]."""
    announced: float | None
    """Time at which it was known [s]."""
    synchronous: bool
    """True where it is a synchronous onset."""
    level: float
    """Level over the clearance that a whirl exceeds from the onset on, as the detector states it."""
    ratio: float | None
    """Whirl ratio."""
    motion: Callable[[Any], Sequence[str]]
    """States of the string at times [s]."""
    marks: tuple[Callable[[Any], Sequence[str]], ...]
    """States of each mark at times [s]."""


Detector = Callable[[FrozenRecord], Finding]


def by_analyzer(record: FrozenRecord) -> Finding:
    """Findings of `drill_twin.whirl.Analyzer`."""
    analyzer = Analyzer(record.marks)
    analyzer.push_block(record.stamp, record.position, record.spin, record.top_speed)
    return finding_of(analyzer.summary())


def finding_of(found: Summary) -> Finding:
    """Finding of a summary of the analyzer."""
    onset = found.onset

    def timeline(periods: Sequence[MotionPeriod]) -> Callable[[Any], Sequence[str]]:
        starts = np.array([period.start_s for period in periods])

        def states(time: Any) -> list[str]:
            index = np.maximum(np.searchsorted(starts, time, side="right") - 1, 0)
            return [periods[i].state.value if periods else "not observable" for i in index.tolist()]

        return states

    marks = tuple(timeline(periods) for periods in found.mark_motion.values())
    return Finding(
        None if onset is None else onset.time_s, None if onset is None else onset.detected_s,
        onset is not None and onset.kind == "synchronous",
        ONSET_RADIUS, found.mean_ratio, timeline(found.motion), marks,
    )  # fmt: skip


def _square() -> NDArray[np.int64]:
    return np.zeros((len(STATES), len(STATES)), np.int64)


@dataclass(eq=False)
class FrozenScore:
    """Scores over records of one kind, or of all."""

    records: int = 0
    error: list[float] = field(default_factory=list)
    """Found minus true onset [rev], where both exist."""
    delay: list[float] = field(default_factory=list)
    """From the true onset to its announcement [rev]."""
    ratio_error: list[float] = field(default_factory=list)
    """Found minus true whirl ratio, over the true one."""
    missed: list[str] = field(default_factory=list)
    false: list[str] = field(default_factory=list)
    """Records without a whirl in which an onset was found."""
    still: int = 0
    """Records without a whirl."""
    undated: int = 0
    """Records whose onset was found where its time is not known."""
    synchronous: list[bool] = field(default_factory=list)
    """True if a synchronous onset was found, by record with a large synchronous response."""
    far: list[tuple[float, str]] = field(default_factory=list)
    """Onsets more than half a revolution off: error [rev] and record."""
    string: NDArray[np.int64] = field(default_factory=_square)
    """Confusion of the string's states, true (row) and found (column), in eighths of a revolution."""
    marks: NDArray[np.int64] = field(default_factory=_square)

    def add(self, record: FrozenRecord, found: Finding) -> None:
        """Add what a detector says of a record."""
        truth, name = record.truth, f"{record.kind} {record.name}"
        if not truth.scored:
            return
        self.records += 1
        self._count(truth, found)
        true = truth.began(found.level)
        if truth.synchronous:
            self.synchronous.append(found.onset is not None and found.synchronous)
            if found.onset is not None and not found.synchronous:
                self.false.append(name)
        elif true is None:
            self.still += 1
            if found.onset is not None:
                self.false.append(name)
        elif found.onset is None:
            self.missed.append(name)
        else:
            if truth.ratio is not None and found.ratio is not None:
                self.ratio_error.append(found.ratio / truth.ratio - 1.0)
            if not truth.dated:
                self.undated += 1
                return
            at, known, began = np.interp([found.onset, found.announced or found.onset, true], truth.time, truth.turns)
            self.error.append(float(at - began))
            self.delay.append(float(known - began))
            if abs(at - began) > 0.5:
                self.far.append((float(at - began), name))

    def _count(self, truth: Truth, found: Finding) -> None:
        _add(self.string, truth.string_states(found.level), found.motion(truth.time))
        for k, states in enumerate(found.marks):
            _add(self.marks, truth.mark_states(found.level, k), states(truth.time))

    def merge(self, other: FrozenScore) -> None:
        """Add another score."""
        for key, value in vars(other).items():
            setattr(self, key, getattr(self, key) + value)

    @property
    def onsets(self) -> int:
        """Records with a whirl."""
        return len(self.error) + len(self.missed)

    def met(self, tolerance: float) -> int:
        """Onsets found within a tolerance [rev]."""
        return sum(abs(error) <= tolerance for error in self.error)

    def plain(self) -> dict[str, Any]:
        """Plain types for JSON."""
        ratio = np.abs(self.ratio_error)
        return {
            "records": self.records, "onsets": self.onsets, "half": self.met(0.5), "one": self.met(1.0),
            "missed": len(self.missed), "still": self.still, "false": len(self.false),
            "undated": self.undated, "synchronous": [sum(self.synchronous), len(self.synchronous)],
            "median_ratio_error": float(np.median(ratio)) if ratio.size else None,
            "ratio_error_95": float(np.percentile(ratio, 95)) if ratio.size else None,
            "median_delay_rev": float(np.median(self.delay)) if self.delay else None,
            "string": macro_f1(self.string), "string_old": macro_f1(self.string, new=False),
            "marks": macro_f1(self.marks), "marks_old": macro_f1(self.marks, new=False),
            "string_f1": f1(self.string), "marks_f1": f1(self.marks),
            "false_records": self.false, "missed_records": self.missed, "far": sorted(self.far),
        }  # fmt: skip


def _add(confusion: NDArray[np.int64], true: Sequence[str], found: Sequence[str]) -> None:
    for own, other in zip(true, found, strict=True):
        if own:
            confusion[STATES.index(own), STATES.index(other)] += 1


def f1(confusion: NDArray[np.int64], *, new: bool = True) -> dict[str, float]:
    """F1 of each state that occurs in the truth, with the new states or without the time in which they are true."""
    kept = confusion if new else np.where([[state in NEW] for state in STATES], 0, confusion)
    return {
        state: 2.0 * int(kept[k, k]) / int(kept[k].sum() + kept[:, k].sum())
        for k, state in enumerate(STATES) if kept[k].any()
    }  # fmt: skip


def macro_f1(confusion: NDArray[np.int64], *, new: bool = True) -> float | None:
    """Mean F1 of the states that occur in the truth."""
    found = f1(confusion, new=new)
    return sum(found.values()) / len(found) if found else None


def score_of(records: Iterable[FrozenRecord], detector: Detector = by_analyzer) -> dict[str, FrozenScore]:
    """Score of a detector by kind of record, and of all kinematic records as `all`."""
    scores: dict[str, FrozenScore] = {}
    for record in records:
        one = FrozenScore()
        one.add(record, detector(record))
        for key in (record.kind, *(("all",) if record.kind != "s" else ())):
            scores.setdefault(key, FrozenScore()).merge(one)
    return scores
