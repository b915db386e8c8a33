# SPDX-License-Identifier: Apache-2.0
"""Check of a finished run: its error before the onset, and confidence intervals of its statistics after it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.report.recording import Recording
from drill_twin.studies.accuracy.errors import largest_distance
from drill_twin.studies.accuracy.measure import AFTER_ONSET, at
from drill_twin.studies.accuracy.motion_run import run_motion
from drill_twin.studies.accuracy.plan import AccuracyPlan

RICHARDSON = 4.0 / 3.0
"""Error over the difference from a run of half the step and twice the elements, for second order."""
BATCHES = 10
SETTLING = 2.0
"""Simulated time after the onset that the statistics leave out [s]."""
CONFIDENCE = 0.95
METHOD = (
    "part before the onset rerun with twice the elements, half the step and a tenth of the tolerance: largest distance "
    "of the marks' paths over the largest deflection, and difference of the onset times, each times 4/3"
)


@dataclass(frozen=True)
class ErrorInterval:
    """Mean over time and its 95 % confidence interval, by the method of batch means (Law 2007, section 9.5.3)."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class AccuracyResult:
    """Error and time of a run: asked for, expected and actual."""

    asked: float
    expected: float
    actual: float | None
    """Measured error [-]; None where it was not checked."""
    how: str
    """Method by which `actual` was measured."""
    expected_seconds: float
    """Expected processor time of computing the motion, without loading, recording and this check [s]."""
    actual_seconds: float
    """Actual one [s]."""
    measuring_seconds: float
    """Processor time of the measurement of the error model; 0 where there was one [s]."""
    check_seconds: float
    """Processor time of this check [s]."""
    orbit_radius: ErrorInterval | None
    """Orbit radius over the clearance, mean of the marks [-]; None without whirl."""
    precession_hz: ErrorInterval | None
    """Precession frequency of the mark with the largest orbit [Hz], positive = forward."""


def check(
    plan: AccuracyPlan,
    recording: Recording,
    motion_seconds: float,
    *,
    rerun: bool = True,
    progress: Callable[[float], None] = lambda _: None,
) -> AccuracyResult:
    """Compare a finished run with its plan.

    Args:
        plan: The plan of the run.
        recording: The run.
        motion_seconds: Processor time of computing its motion [s].
        rerun: Run the part before the onset again with twice the elements and half the step; else `actual` is None.
        progress: Called with the simulated time of the rerun [s].

    Raises:
        RunError: The finer run fails.
    """
    began = time.thread_time()
    onset = recording.summary.onset_s
    line = recording.centre_lines()
    times = recording.marks.time
    clearance = np.array([place.clearance for place in recording.scene.mark_table])
    return AccuracyResult(
        asked=plan.asked,
        expected=plan.expected,
        actual=_actual(plan, times, line, onset, progress) if rerun else None,
        how=METHOD if rerun else "not checked",
        expected_seconds=plan.seconds,
        actual_seconds=motion_seconds,
        measuring_seconds=plan.measuring,
        check_seconds=time.thread_time() - began,
        orbit_radius=interval(times, (np.abs(line) / clearance).mean(axis=1), onset),
        precession_hz=interval(times, _precession(times, line), onset),
    )


def _actual(
    plan: AccuracyPlan, time: Array, line: ComplexArray, onset: float | None, progress: Callable[[float], None]
) -> float:
    numerics = plan.scene.numerics
    finer = at(plan.scene, 2 * int(numerics.elements), 0.5 * float(numerics.step), 0.1 * plan.scene.tolerance)
    motion = run_motion(finer, after_onset=AFTER_ONSET, progress=progress)
    common = min(time.size, motion.time.size)
    true = motion.centre[:common, :, 0] + 1j * motion.centre[:common, :, 1]
    early = time[:common] <= min(motion.onset if math.isfinite(motion.onset) else math.inf, time[-1])
    path = largest_distance(line[:common][early], true[early])
    if onset is None or not math.isfinite(motion.onset):
        return RICHARDSON * path if (onset is None) == (not math.isfinite(motion.onset)) else 1.0
    return RICHARDSON * max(path, abs(onset - motion.onset) / motion.onset)


def _precession(time: Array, line: ComplexArray) -> Array:
    mark = int(np.argmax(np.abs(line).mean(axis=0)))
    turns: Array = np.gradient(np.unwrap(np.angle(line[:, mark])), time) / math.tau
    return turns


def interval(time: Array, values: Array, onset: float | None) -> ErrorInterval | None:
    """Confidence interval of the mean after the onset; None where the record after it is too short.

    Args:
        time: [s], shape (T,).
        values: Shape (T,).
        onset: Onset [s]; None: no onset.
    """
    if onset is None:
        return None
    late = values[time > onset + SETTLING]
    size = late.size // BATCHES
    if size < 2:
        return None
    means = late[: size * BATCHES].reshape(BATCHES, size).mean(axis=1)
    half = float(student.ppf(0.5 + 0.5 * CONFIDENCE, BATCHES - 1) * means.std(ddof=1) / math.sqrt(BATCHES))
    return ErrorInterval(float(means.mean()), float(means.mean()) - half, float(means.mean()) + half)
