# SPDX-License-Identifier: Apache-2.0
"""Whirl analysis of a stream of samples of the marks.

The same samples give the same findings to the last bit, live or from a bag: only header stamps are used as time, every
sum is accumulated in the order of the samples. The cost of a sample does not grow with time.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Integers
from drill_twin.core.compile.packed_arguments import bind, pack
from drill_twin.whirl.analysis_loop import compiled
from drill_twin.whirl.analyzer_state import (
    BLOCK,
    CHANGED,
    COUNT,
    DECIDED,
    HAS_FORCE,
    HAS_SPIN,
    NEW,
    NEXT,
    AnalyzerState,
)
from drill_twin.whirl.criteria import Criteria
from drill_twin.whirl.findings import Findings, FoundRows, Onset, Quality, Summary
from drill_twin.whirl.marks import AnalysisError, MarkArrays, MarkInfo, check_marks
from drill_twin.whirl.motion.stick_slip import MEAN, SECOND_POLE, StickSlip
from drill_twin.whirl.run_statistics import SAMPLE_RATE
from drill_twin.whirl.summary import summarise
from drill_twin.whirl.whirl_estimator import WhirlEstimator

LARGEST_STAMP = 1 << 62
"""Largest stamp [ns]."""

FloatArray = NDArray[np.floating[Any]]


class Analyzer:
    """Finds whirl in the motion of marks, sample by sample."""

    def __init__(
        self,
        marks: Sequence[MarkInfo],
        criteria: Criteria | None = None,
        *,
        contact_known: bool = True,
        top_known: bool = True,
    ) -> None:
        """Start an analysis of `marks`.

        Args:
            marks: Marks on the string.
            criteria: Numbers of the criteria.
            contact_known: Their positions are those about the axis of the hole.
            top_known: The speed of the top drive is measured by itself, and is not that of the bit.

        Raises:
            AnalysisError: No mark, or two of one name.
        """
        self.marks = check_marks(marks)
        self.criteria, self._contact_known = criteria or Criteria(), contact_known
        self._top_known = top_known
        self.reset()

    def reset(self) -> None:
        """Discard all samples."""
        self._names = tuple(mark.name for mark in self.marks)
        self._bit = StickSlip(top_known=self._top_known)
        offsets = np.array([mark.wall_offset for mark in self.marks])
        self._state = AnalyzerState.of(MarkArrays.of(self.marks), offsets, self.criteria, self._bit.speed)
        self._packed = pack(self._state)
        self._analyse = bind(compiled().analyse, self._packed)
        self._decisions = WhirlEstimator(self._names, self._state, contact_known=self._contact_known)
        self._flow, self._radius = self._state.flow, self._state.samples.radius
        self._shapes = frozenset(((len(self.marks), 2), (len(self.marks), 3)))
        self._counted = self._state.clock.stamps, self._state.samples.quality, self._state.statistics.numbers
        self._findings = self._new_findings()

    @property
    def findings(self) -> Findings:
        """The findings so far."""
        return self._findings

    @property
    def quality(self) -> Quality:
        """Counts of good and bad samples so far."""
        return self._stamp_and_quality()[1]

    def _stamp_and_quality(self) -> tuple[int, Quality]:
        stamps, samples, numbers = self._counted
        _, _, stamp, duplicate, late = stamps.tolist()
        accepted, incomplete, missing, gaps = samples.tolist()
        return stamp, Quality(accepted, duplicate, late, incomplete, missing, gaps, numbers.item(SAMPLE_RATE))

    @property
    def bit_speed(self) -> tuple[float, float]:
        """Low-passed speed of the bit and its slow mean [rad/s]."""
        numbers = self._bit.speed.numbers
        return numbers.item(SECOND_POLE), numbers.item(MEAN)

    def summary(self) -> Summary:
        """The findings of the whole run so far."""
        state = self._state
        return summarise(state.statistics, self._names, self._decisions, state.samples.largest, self._bit, self.quality)

    def date_onset(self, onset: Onset) -> None:
        """Replace the onset, which has been found, by the same with a time that is known better."""
        self._decisions.date_onset(onset)
        self._findings = replace(self._findings, onset=onset)

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
        stamps, positions, spins, forces, speeds, counts = self._state.block
        stamps[0], speeds[0, 0], speeds[0, 1] = stamp, top_speed, bit_speed
        positions[0] = position[:, :2]
        if spin is not None:
            spins[0] = spin
        if wall_force is not None:
            forces[0] = wall_force
        counts[COUNT], counts[NEXT] = 1, 0
        counts[HAS_SPIN], counts[HAS_FORCE] = spin is not None, wall_force is not None
        for _ in self._analysed():
            pass
        return self._present()

    def push_bit_speed(self, stamp_ns: int, bit_speed: float) -> Findings:
        """Add a speed of the bit [rad/s] alone, at a header stamp [ns], and return the findings after it."""
        self._bit.push(stamp_ns * 1e-9, bit_speed)
        bit = self._bit
        self._findings = self._findings.with_sample(
            stamp_ns, self._radius.copy(), self.quality, bit.motion, bit.criterion, bit.index
        )
        return self._findings

    def push_block(
        self,
        stamps_ns: Integers,
        position: FloatArray,
        spin: FloatArray | None,
        top_speed: FloatArray,
        wall_force: FloatArray | None = None,
        bit_speed: FloatArray | None = None,
    ) -> FoundRows:
        """Add n samples, as `push` one by one, and return the findings after each.

        Args:
            stamps_ns: Header stamps [ns], shape (n,).
            position: Marked points [m], shape (n, m, 3) or (n, m, 2).
            spin: Spin at the marks [rad], shape (n, m), or None.
            top_speed: Speed of the top drive [rad/s], shape (n,).
            wall_force: Normal wall force at the marks [N], shape (n, m), or None.
            bit_speed: Speed of the bit [rad/s], shape (n,), or None.
        """
        stamps, positions, spins, forces, speeds, counts = self._state.block
        counts[HAS_SPIN], counts[HAS_FORCE] = spin is not None, wall_force is not None
        count = len(stamps_ns)
        found = FoundRows(self._findings, [], np.empty((count, len(self.marks), 4)), np.empty(count), {})
        for first in range(0, len(stamps_ns), BLOCK):
            rows = slice(first, first + BLOCK)
            n = counts[COUNT] = len(stamps_ns[rows])
            counts[NEXT] = 0
            stamps[:n] = stamps_ns[rows]
            positions[:n] = position[rows, :, :2]
            speeds[:n, 0] = top_speed[rows]
            speeds[:n, 1] = math.nan if bit_speed is None else bit_speed[rows]
            if spin is not None:
                spins[:n] = spin[rows]
            if wall_force is not None:
                forces[:n] = wall_force[rows]
            for at in self._analysed():
                found.changes[first + at] = self._present()
            self._present()
            found.stamps.extend(self._state.found.stamp[:n].tolist())
            found.values[rows] = self._state.found.values[:n]
            found.bit_index[rows] = self._state.found.bit_index[:n]
        return found

    def _analysed(self) -> Iterator[int]:
        """Analyse the block and decide where compiled code leaves it to Python; yield the samples with a decision."""
        while outcome := self._analyse():
            if outcome == CHANGED:
                yield int(self._state.block.counts[NEXT]) - 1
            elif outcome < 0:
                self._bit.decide(-outcome)
                self._flow[DECIDED] = 1
            else:
                self._decisions.decide[outcome]()
                self._flow[DECIDED] = 1

    def _present(self) -> Findings:
        """Findings after the last sample that was analysed."""
        if self._flow[NEW]:
            self._findings = self._new_findings()
        stamp, quality = self._stamp_and_quality()
        bit = self._bit
        self._findings = self._findings.with_sample(
            stamp, self._radius.copy(), quality, bit.motion, bit.criterion, bit.index
        )
        return self._findings

    def _checked_stamp(
        self, stamp_ns: int, position: FloatArray, spin: FloatArray | None, wall_force: FloatArray | None
    ) -> int:
        m = len(self.marks)
        if position.shape not in self._shapes:
            raise AnalysisError(f"expected positions of shape ({m}, 3) for {m} marks, found {position.shape}")
        if spin is not None and spin.shape != self._radius.shape:
            raise AnalysisError(f"expected spin of shape ({m},) for {m} marks, found {spin.shape}")
        if wall_force is not None and wall_force.shape != self._radius.shape:
            raise AnalysisError(f"expected wall force of shape ({m},) for {m} marks, found {wall_force.shape}")
        try:
            stamp = operator.index(stamp_ns)
        except TypeError as error:
            raise AnalysisError(f"expected a stamp in whole nanoseconds, found {stamp_ns!r}") from error
        if abs(stamp) > LARGEST_STAMP:
            raise AnalysisError(
                f"expected a stamp of at most {LARGEST_STAMP} ns, 146 years from the epoch, found {stamp}"
            )
        return stamp

    def _new_findings(self) -> Findings:
        """The present estimates."""
        state, decisions = self._state, self._decisions
        orbit, hysteresis, clearance = state.orbit, state.motion.hysteresis, state.marks.clearance
        state.flow[NEW] = 0
        states, shares, definite = hysteresis.states, hysteresis.confidence, state.carrier.definite
        return Findings(
            stamp_ns=0,
            time_s=0.0,
            marks=self._names,
            orbit_radius=self._radius.copy(),
            precession=orbit.precession.copy(),
            ratio=orbit.ratio.copy(),
            confidence=orbit.confidence.copy(),
            whirl_radius=orbit.radius[0] * clearance,
            synchronous_radius=orbit.synchronous * clearance,
            contact_fraction=orbit.contact.copy(),
            phase=state.shape.phase.copy(),
            planarity=state.shape.planarity,
            rotation=orbit.rotation,
            state=states[:-1],
            state_confidence=shares[:-1] * definite,
            criterion=tuple(decisions.criterion[:-1]),
            motion=states[-1],
            motion_confidence=float(shares[-1] * definite[state.motion.mark[-1]]),
            motion_criterion=decisions.criterion[-1],
            bit=self._bit.motion,
            bit_criterion=self._bit.criterion,
            onset=decisions.onset,
            quality=self.quality,
        )
