# SPDX-License-Identifier: Apache-2.0
"""Analysis of labelled records, and its scores against the ground truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.whirl import Analyzer, MotionPeriod, Summary
from drill_twin_evidence.detection.ground_truth import Truth
from drill_twin_evidence.detection.signals import Record

STATES = (
    "at rest",
    "rotation about a fixed axis",
    "synchronous whirl",
    "forward whirl",
    "rolling along the wall",
    "second bending",
    "irregular",
    "backward whirl",
    "spiral",
    "not observable",
    "swinging in a plane",
    "creeping along the wall",
    "striking the wall",
)
"""Motion states in the order of the confusion matrix."""
MAX_ONSET_ERROR = 0.5
"""Tolerance of an onset [rev]."""


def analyse(record: Record) -> Summary:
    """Summary of the analyzer for a record."""
    analyzer = Analyzer(record.marks)
    analyzer.push_block(record.stamp, record.position, record.spin, record.top_speed, record.force)
    return analyzer.summary()


@dataclass(eq=False)
class Score:
    """Scores over many records."""

    onset_error: list[float] = field(default_factory=list)
    """Found minus true onset [rev], where both exist."""
    delay: list[float] = field(default_factory=list)
    """Time from the true onset to its detection [rev]."""
    missed: int = 0
    """Records with an onset that was not found."""
    false: int = 0
    """Records without one in which one was found."""
    records: int = 0
    string: NDArray[np.int64] = field(default_factory=lambda: np.zeros((len(STATES), len(STATES)), np.int64))
    """Confusion of the string's states: true (row) and found (column), in eighths of a revolution."""
    marks: NDArray[np.int64] = field(default_factory=lambda: np.zeros((len(STATES), len(STATES)), np.int64))
    """Confusion of the states of the marks."""

    def add(self, truth: Truth, found: Summary, rotation: float) -> None:
        """Add a record with its ground truth and rotation [rev/s]."""
        self.records += 1
        if truth.onset is None:
            self.false += found.onset is not None
        elif found.onset is None:
            self.missed += 1
        else:
            self.onset_error.append((found.onset.time_s - truth.onset) * rotation)
            self.delay.append((found.onset.detected_s - truth.onset) * rotation)
        _count(self.string, truth.time, truth.motion, found.motion)
        for labels, periods in zip(truth.marks, found.mark_motion.values(), strict=True):
            _count(self.marks, truth.time, labels, periods)

    def merge(self, other: Score) -> None:
        """Add another score."""
        self.onset_error += other.onset_error
        self.delay += other.delay
        self.missed += other.missed
        self.false += other.false
        self.records += other.records
        self.string += other.string
        self.marks += other.marks

    @property
    def onsets(self) -> int:
        """Records with an onset."""
        return len(self.onset_error) + self.missed

    @property
    def met(self) -> int:
        """Onsets that were found within half a revolution."""
        return sum(abs(error) <= MAX_ONSET_ERROR for error in self.onset_error)


def f1_scores(confusion: NDArray[np.int64]) -> dict[str, float]:
    """F1 of each state that occurs in the truth: 2 TP / (2 TP + FP + FN)."""
    scores = {}
    for k, state in enumerate(STATES):
        true, found = int(confusion[k].sum()), int(confusion[:, k].sum())
        if true:
            scores[state] = 2.0 * int(confusion[k, k]) / (true + found)
    return scores


def macro_f1(confusion: NDArray[np.int64]) -> float:
    """Mean F1 of the states that occur in the truth."""
    scores = f1_scores(confusion)
    return sum(scores.values()) / len(scores) if scores else float("nan")


def states_at(time: Array, periods: Sequence[MotionPeriod]) -> list[str]:
    """States of a timeline at given times [s]; of periods with one start, the last."""
    starts = np.array([period.start_s for period in periods])
    index = np.maximum(np.searchsorted(starts, time, side="right") - 1, 0)
    return [periods[i].state.value for i in index.tolist()]


def _count(confusion: NDArray[np.int64], time: Array, labels: Sequence[str], periods: Sequence[MotionPeriod]) -> None:
    if not periods:
        return
    for true, found in zip(labels, states_at(time, periods), strict=True):
        if true:
            confusion[STATES.index(true), STATES.index(found)] += 1
