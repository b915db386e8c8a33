# SPDX-License-Identifier: Apache-2.0
"""Whirl analysis of a stream of samples of the marks.

The same samples give the same findings to the last bit, live or from a bag: only header stamps are used as time, every
sum is accumulated in the order of the samples. The cost of a sample does not grow with time.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.base.arrays import Array
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.findings import Findings, Quality, Summary
from drill_twin.whirl.marks import AnalysisError, MarkInfo, check_marks
from drill_twin.whirl.motion.stick_slip import StickSlip
from drill_twin.whirl.rotation import Rotation, StampFilter
from drill_twin.whirl.run_statistics import RunStatistics
from drill_twin.whirl.sample_bins import SampleBins, unit_phasor
from drill_twin.whirl.whirl_estimator import WhirlEstimator

LARGEST_RADIUS = 3.0
"""Largest plausible radius of a mark over its clearance; beyond is an error of measurement."""

FloatArray = NDArray[np.floating[Any]]


class Analyzer:
    """Finds whirl in the motion of marks, sample by sample."""

    def __init__(self, marks: Sequence[MarkInfo], criteria: Criteria | None = None) -> None:
        """Start an analysis of `marks`.

        Raises:
            AnalysisError: No mark, or two of one name.
        """
        self.marks = check_marks(marks)
        self.criteria = criteria or Criteria()
        self.reset()

    def reset(self) -> None:
        """Discard all samples."""
        m = len(self.marks)
        self._names = tuple(mark.name for mark in self.marks)
        self._clearance = np.array([mark.clearance for mark in self.marks])
        self._largest_radius = LARGEST_RADIUS * self._clearance + [mark.wall_offset for mark in self.marks]
        self._stamps, self._rotation, self._bins = StampFilter(), Rotation(), SampleBins(m)
        self._sample = np.zeros((2, m), complex)
        self._plane = self._sample[0].view(float).reshape(m, 2)
        self._spin = np.zeros(m)
        self._estimator = WhirlEstimator(self.marks, self.criteria)
        self._statistics = RunStatistics(m)
        self._bit = StickSlip()
        self._accepted = self._incomplete = self._missing = 0
        self._rate = math.nan
        self._radius = np.full(m, math.nan)
        self._findings = self._new_findings(0)

    @property
    def findings(self) -> Findings:
        """The findings so far."""
        return self._findings

    @property
    def quality(self) -> Quality:
        """Counts of good and bad samples so far."""
        stamps = self._stamps
        return Quality(
            self._accepted,
            stamps.duplicate,
            stamps.late,
            self._incomplete,
            self._missing,
            self._estimator.gaps,
            self._rate,
        )

    def summary(self) -> Summary:
        """The findings of the whole run so far."""
        return self._statistics.summary(self._names, self._estimator, self._bit, self.quality)

    def push(
        self,
        stamp_ns: int,
        position: FloatArray,
        spin: FloatArray | None,
        top_speed: float,
        wall_force: FloatArray | None = None,
        bit_speed: float = math.nan,
    ) -> Findings:
        """Add one sample and return the findings after it.

        Args:
            stamp_ns: Header stamp [ns].
            position: Marked points [m], shape (m, 3) or (m, 2): x, y across the hole; nan for a mark not seen.
            spin: Spin at the marks [rad], shape (m,), wrapped or not; None throughout where it is not measured.
            top_speed: Speed of the top drive [rad/s]; nan where unknown, the spin then gives the rotation.
            wall_force: Normal wall force at the marks [N], shape (m,), if known; it makes the contact fraction exact.
            bit_speed: Speed of the bit [rad/s], if known; used for stick-slip only.

        Raises:
            AnalysisError: An array has another shape, or the stamp is not an integer.
        """
        position = np.asarray(position)
        stamp = self._checked_stamp(stamp_ns, position, spin, wall_force)
        if not self._stamps.is_new(stamp):
            return self._skip()
        self._bit.push(stamp * 1e-9, bit_speed)
        with np.errstate(invalid="ignore", over="ignore"):
            return self._analyse(stamp, position, spin, float(top_speed), wall_force)

    def _checked_stamp(
        self, stamp_ns: int, position: FloatArray, spin: FloatArray | None, wall_force: FloatArray | None
    ) -> int:
        m = len(self.marks)
        if position.shape not in {(m, 3), (m, 2)}:
            raise AnalysisError(f"expected positions of shape ({m}, 3) for {m} marks, found {position.shape}")
        for name, values in (("spin", spin), ("wall force", wall_force)):
            if values is not None and values.shape != (m,):
                raise AnalysisError(f"expected {name} of shape ({m},) for {m} marks, found {values.shape}")
        try:
            return operator.index(stamp_ns)
        except TypeError as error:
            raise AnalysisError(f"expected a stamp in whole nanoseconds, found {stamp_ns!r}") from error

    def _analyse(
        self, stamp: int, position: FloatArray, spin: FloatArray | None, top_speed: float, force: FloatArray | None
    ) -> Findings:
        estimator, rotation = self._estimator, self._rotation
        separation = estimator.separation
        if separation.spin_given is None:
            separation.start(spin_given=spin is not None)
        # Copied into arrays of fixed layout: the layout of the caller's must not change the last bits.
        place, phasor = self._sample
        self._plane[:] = position[:, :2]
        if spin is None:
            radius = np.abs(place)
        else:
            self._spin[:] = spin
            unit_phasor(self._spin, phasor)
            radius = np.abs(place - separation.arm * phasor)
        seen = radius <= self._largest_radius
        marks_seen = seen.tolist()
        rotation_known = spin is not None or math.isfinite(top_speed)
        if (spin is not None) is not separation.spin_given or not rotation_known or True not in marks_seen:
            self._incomplete += 1
            return self._skip()
        if self._accepted == 0:
            estimator.origin = stamp * 1e-9
        rotation.update(self._stamps.accept(stamp), top_speed, None if spin is None else self._spin)
        time = self._stamps.seconds
        bin_full = self._bins.is_full(time, rotation.revolutions)
        if bin_full:
            self._close_bin()
        if spin is None:
            phasor[:] = complex(math.cos(rotation.angle), math.sin(rotation.angle))
            radius = np.abs(place - separation.arm * phasor)
        complete = False not in marks_seen
        if not complete:
            self._missing += marks_seen.count(False)
            radius[~seen] = math.nan
        self._bins.add(time, rotation.angle, rotation.revolutions, self._sample, None if complete else seen, force)
        self._accepted += 1
        if separation.known:
            self._radius = radius
            np.fmax(self._statistics.largest, radius, out=self._statistics.largest)
        self._findings = self._new_findings(stamp) if bin_full else self._with_sample(stamp, self._radius)
        return self._findings

    def _close_bin(self) -> None:
        """Update all estimates with the full bin."""
        full = self._bins.close()
        new_estimate = self._estimator.update(full)
        self._statistics.update(full, self._estimator, new_estimate=new_estimate)
        self._rate = self._statistics.samples_per_revolution

    def _skip(self) -> Findings:
        """The last findings with the new counts, after a sample that was skipped."""
        last = self._findings
        self._findings = self._with_sample(last.stamp_ns, last.orbit_radius)
        return self._findings

    def _with_sample(self, stamp: int, radius: Array) -> Findings:
        bit = self._bit
        return self._findings.with_sample(stamp, radius, self.quality, bit.motion, bit.criterion)

    def _new_findings(self, stamp: int) -> Findings:
        estimator = self._estimator
        orbit, hysteresis, shape = estimator.orbit, estimator.motion.hysteresis, estimator.shape
        states, shares = hysteresis.states, hysteresis.confidence
        return Findings(
            stamp_ns=stamp,
            time_s=stamp * 1e-9,
            marks=self._names,
            orbit_radius=self._radius,
            precession=estimator.precession,
            ratio=estimator.ratio,
            confidence=estimator.confidence,
            whirl_radius=orbit.radius[0] * self._clearance,
            synchronous_radius=orbit.synchronous * self._clearance,
            contact_fraction=orbit.contact,
            phase=shape.phase,
            planarity=shape.planarity,
            rotation=orbit.rotation,
            state=states[:-1],
            state_confidence=shares[:-1],
            criterion=tuple(hysteresis.criterion[:-1]),
            motion=states[-1],
            motion_confidence=float(shares[-1]),
            motion_criterion=hysteresis.criterion[-1],
            bit=self._bit.motion,
            bit_criterion=self._bit.criterion,
            onset=estimator.onset,
            quality=self.quality,
        )
