# SPDX-License-Identifier: Apache-2.0
"""The analyzer: samples of the marks go in one by one, findings come out.

The same samples give the same findings to the last bit, live or from a bag: only header stamps count, every sum runs
in the order of the samples, and nothing depends on the clock. The cost of a sample does not grow with time.
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
from drill_twin.whirl.marks import AnalysisError, MarkInfo, checked
from drill_twin.whirl.motion.stick_slip import StickSlip
from drill_twin.whirl.rotation import Rotation, Stamps
from drill_twin.whirl.run_statistics import Tally
from drill_twin.whirl.sample_bins import Bins, unit_turn
from drill_twin.whirl.whirl_estimator import Estimates

FARTHEST = 3.0
"""A mark farther out than this times the clearance is an error of measurement."""

FloatArray = NDArray[np.floating[Any]]


class Analyzer:
    """Finds whirl in the motion of marks, sample by sample."""

    def __init__(self, marks: Sequence[MarkInfo], criteria: Criteria | None = None) -> None:
        """Starts an analysis of `marks`.

        Raises:
            AnalysisError: No mark, or two of one name.
        """
        self.marks = checked(marks)
        self.criteria = criteria or Criteria()
        self.reset()

    def reset(self) -> None:
        """Forgets everything, as if no sample had come."""
        m = len(self.marks)
        self._names = tuple(mark.name for mark in self.marks)
        self._clearance = np.array([mark.clearance for mark in self.marks])
        self._farthest = FARTHEST * self._clearance + [mark.wall_offset for mark in self.marks]
        self._stamps, self._rotation, self._bins = Stamps(), Rotation(), Bins(m)
        self._sample = np.zeros((2, m), complex)
        self._plane = self._sample[0].view(float).reshape(m, 2)
        self._spin = np.zeros(m)
        self._estimates = Estimates(self.marks, self.criteria)
        self._tally = Tally(m)
        self._bit = StickSlip()
        self._accepted = self._incomplete = self._missing = 0
        self._rate = math.nan
        self._radius = np.full(m, math.nan)
        self._findings = self._report(0)

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
            self._estimates.gaps,
            self._rate,
        )

    def summary(self) -> Summary:
        """The findings of the whole run so far."""
        return self._tally.summary(self._names, self._estimates, self._bit, self.quality)

    def push(
        self,
        stamp_ns: int,
        position: FloatArray,
        spin: FloatArray | None,
        top_speed: float,
        wall_force: FloatArray | None = None,
        bit_speed: float = math.nan,
    ) -> Findings:
        """Takes in one sample and returns what is known after it.

        Args:
            stamp_ns: Header stamp [ns].
            position: Marked points [m], shape (m, 3) or (m, 2): x, y across the hole; nan for a mark not seen.
            spin: Spin at the marks [rad], shape (m,), wrapped or not; None throughout where it is not measured.
            top_speed: Speed of the top drive [rad/s]; nan where unknown, the spin then gives the rotation.
            wall_force: Normal wall force at the marks [N], shape (m,), if known; it sharpens the contact fraction.
            bit_speed: Speed of the bit [rad/s], if known; it shows stick-slip, and nothing else rests on it.

        Raises:
            AnalysisError: An array has another shape, or the stamp is no whole number.
        """
        position = np.asarray(position)
        stamp = self._checked(stamp_ns, position, spin, wall_force)
        if not self._stamps.fresh(stamp):
            return self._skip()
        self._bit.push(stamp * 1e-9, bit_speed)
        with np.errstate(invalid="ignore", over="ignore"):
            return self._take(stamp, position, spin, float(top_speed), wall_force)

    def _checked(
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

    def _take(
        self, stamp: int, position: FloatArray, spin: FloatArray | None, top_speed: float, force: FloatArray | None
    ) -> Findings:
        estimates, rotation = self._estimates, self._rotation
        baseline = estimates.baseline
        if baseline.spin_given is None:
            baseline.begin(spin_given=spin is not None)
        place, turn = self._sample
        # Copies into arrays of our own: results must not depend on the layout of the caller's.
        self._plane[:] = position[:, :2]
        if spin is None:
            radius = np.abs(place)
        else:
            self._spin[:] = spin
            unit_turn(self._spin, turn)
            radius = np.abs(place - baseline.arm * turn)
        seen = radius <= self._farthest
        marks_seen = seen.tolist()
        rotation_known = spin is not None or math.isfinite(top_speed)
        if (spin is not None) is not baseline.spin_given or not rotation_known or True not in marks_seen:
            self._incomplete += 1
            return self._skip()
        if self._accepted == 0:
            estimates.origin = stamp * 1e-9
        rotation.advance(self._stamps.take(stamp), top_speed, None if spin is None else self._spin)
        time = self._stamps.seconds
        closes = self._bins.due(time, rotation.travel)
        if closes:
            self._close()
        if spin is None:
            turn[:] = complex(math.cos(rotation.angle), math.sin(rotation.angle))
            radius = np.abs(place - baseline.arm * turn)
        whole = False not in marks_seen
        if not whole:
            self._missing += marks_seen.count(False)
            radius[~seen] = math.nan
        self._bins.add(time, rotation.angle, rotation.travel, self._sample, None if whole else seen, force)
        self._accepted += 1
        if baseline.known:
            self._radius = radius
            np.fmax(self._tally.largest, radius, out=self._tally.largest)
        self._findings = self._report(stamp) if closes else self._after(stamp, self._radius)
        return self._findings

    def _after(self, stamp: int, radius: Array) -> Findings:
        bit = self._bit
        return self._findings.after(stamp, radius, self.quality, bit.motion, bit.criterion)

    def _close(self) -> None:
        """Closes the full bin."""
        full = self._bins.close()
        fresh = self._estimates.update(full)
        self._tally.add(full, self._estimates, fresh=fresh)
        self._rate = self._tally.samples_per_revolution

    def _skip(self) -> Findings:
        """The last findings with the new counts, after a sample that was skipped."""
        last = self._findings
        self._findings = self._after(last.stamp_ns, last.orbit_radius)
        return self._findings

    def _report(self, stamp: int) -> Findings:
        estimates = self._estimates
        orbit, votes, shape = estimates.orbit, estimates.motion.votes, estimates.shape
        states, shares = votes.states, votes.confidence
        return Findings(
            stamp_ns=stamp,
            time_s=stamp * 1e-9,
            marks=self._names,
            orbit_radius=self._radius,
            precession=estimates.precession,
            ratio=estimates.ratio,
            confidence=estimates.confidence,
            whirl_radius=orbit.radius[0] * self._clearance,
            synchronous_radius=orbit.synchronous * self._clearance,
            contact_fraction=orbit.contact,
            phase=shape.phase,
            planarity=shape.planarity,
            rotation=orbit.rotation,
            state=states[:-1],
            state_confidence=shares[:-1],
            criterion=tuple(votes.criterion[:-1]),
            motion=states[-1],
            motion_confidence=float(shares[-1]),
            motion_criterion=votes.criterion[-1],
            bit=self._bit.motion,
            bit_criterion=self._bit.criterion,
            onset=estimates.onset,
            quality=self.quality,
        )
