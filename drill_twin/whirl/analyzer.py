# SPDX-License-Identifier: Apache-2.0
"""Whirl analysis of a stream of samples of the marks.

The same samples give the same findings to the last bit, live or from a bag: only header stamps are used as time, every
sum is accumulated in the order of the samples. The cost of a sample does not grow with time.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Integers, number_or_none
from drill_twin.core.compile.jit import as_python
from drill_twin.core.compile.packed_arguments import bind, pack
from drill_twin.whirl.analysis_loop import CHANGED, compiled
from drill_twin.whirl.analyzer_state import BLOCK, new_state
from drill_twin.whirl.decisions import Decisions
from drill_twin.whirl.findings import Findings, FoundRows, Onset, Quality, Summary
from drill_twin.whirl.marks import AnalysisError, MarkInfo, check_marks, mark_columns
from drill_twin.whirl.motion.states import STATES
from drill_twin.whirl.motion.stick_slip import StickSlip
from drill_twin.whirl.sample_bins import accept, is_new, new_clock, rotate, seconds_of
from drill_twin.whirl.summary import summarise

LARGEST_STAMP = 1 << 62
"""Largest stamp [ns], half of what 64 bits hold, so that the difference of two stamps fits, save for both limits."""

NOT_OBSERVABLE = "whirl is not observable: there are no lateral positions of marks"
_IS_NEW, _ACCEPT, _ROTATE = as_python(is_new), as_python(accept), as_python(rotate)

FloatArray = NDArray[np.floating[Any]]


class Analyzer:
    """Finds whirl in the motion of marks, sample by sample."""

    _kind: Any = None  # numba's type of the state, the same for all; to find it takes 10 ms

    def __init__(self, marks: Sequence[MarkInfo], *, contact_known: bool = True, top_known: bool = True) -> None:
        """Start an analysis of `marks`.

        Args:
            marks: Marks on the string.
            contact_known: The marks' positions are measured from the axis of the hole.
            top_known: The speed of the top drive is measured by itself, and is not the speed of the bit.

        Raises:
            AnalysisError: No mark, or two of one name.
        """
        self.marks = check_marks(marks)
        self._contact_known, self._top_known = contact_known, top_known
        self.reset()

    def reset(self) -> None:
        """Discard all samples."""
        self._names = tuple(mark.name for mark in self.marks)
        self._bit = StickSlip(top_known=self._top_known)
        self._state = new_state(mark_columns(self.marks), self._bit.speed)
        self._packed = pack(self._state, Analyzer._kind)
        Analyzer._kind = self._packed.kind
        self._analyse = bind(compiled().analyse, self._packed)
        self._decisions = Decisions(self._names, self._state, contact_known=self._contact_known)
        self._flow, self._radius = self._state.flow, self._state.samples.radius
        self.findings = self._new_findings()
        """The findings so far."""

    @property
    def quality(self) -> Quality:
        """Counts of good and bad samples so far."""
        clock, samples, rate = self._state.clock, self._state.samples, self._state.statistics.per_revolution
        counts = samples.accepted, clock.duplicate, clock.late, samples.incomplete, samples.missing, samples.gaps
        return Quality(*map(np.ndarray.item, (*counts, rate)))  # of every sample, so without a loop in Python

    @property
    def bit_speed(self) -> tuple[float, float]:
        """Low-passed speed of the bit and its slow mean [rad/s]."""
        return self._bit.speed.speed.item(), self._bit.speed.mean.item()

    def summary(self) -> Summary:
        """The findings of the whole run so far."""
        return summarise(self._state, self._names, self._decisions, self._bit, self.quality)

    def date_onset(self, onset: Onset) -> None:
        """Replace the onset, which has been found, by the same with a time that is known better."""
        self._decisions.date_onset(onset)
        self.findings = replace(self.findings, onset=onset)

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
        spins, forces = (None if part is None else part[None] for part in (spin, wall_force))
        top, bit = np.array([[top_speed], [bit_speed]])
        self.push_block(np.array([stamp_ns]), np.asarray(position)[None], spins, top, forces, bit)
        return self.findings

    def push_bit_speed(self, stamp_ns: int, bit_speed: float) -> Findings:
        """Add a speed of the bit [rad/s] alone, at a header stamp [ns], and return the findings after it."""
        self._bit.push(stamp_ns * 1e-9, bit_speed)
        return self._present(stamp_ns)

    def push_block(
        self,
        stamps_ns: Integers,
        position: FloatArray,
        spin: FloatArray | None,
        top_speed: FloatArray,
        wall_force: FloatArray | None = None,
        bit_speed: FloatArray | None = None,
    ) -> FoundRows:
        """Add n samples, and return the findings after each.

        Args:
            stamps_ns: Header stamps [ns], shape (n,).
            position: Marked points [m], shape (n, m, 3) or (n, m, 2).
            spin: Spin at the marks [rad], shape (n, m), or None.
            top_speed: Speed of the top drive [rad/s], shape (n,).
            wall_force: Normal wall force at the marks [N], shape (n, m), or None.
            bit_speed: Speed of the bit [rad/s], shape (n,), or None.

        Raises:
            AnalysisError: An array has another shape, or a stamp is not an integer.
        """
        self._check(stamps_ns, position, spin, wall_force)
        block, count = self._state.block, len(stamps_ns)
        block.has_spin[0], block.has_force[0] = spin is not None, wall_force is not None
        found = FoundRows(self.findings, [], np.empty((count, len(self.marks), 4)), np.empty(count), {})
        for first in range(0, count, BLOCK):
            rows = slice(first, first + BLOCK)
            n = block.count[0] = len(stamps_ns[rows])
            block.next[0] = 0
            block.stamp[:n], block.position[:n], block.top_speed[:n] = (
                stamps_ns[rows],
                position[rows, :, :2],
                top_speed[rows],
            )
            block.bit_speed[:n] = math.nan if bit_speed is None else bit_speed[rows]
            if spin is not None:
                block.spin[:n] = spin[rows]
            if wall_force is not None:
                block.force[:n] = wall_force[rows]
            for at in self._analysed():
                found.changes[first + at] = self._present()
            self._present()
            found.stamps.extend(block.found_stamp[:n].tolist())
            found.values[rows], found.bit_index[rows] = block.found[:n], block.bit_index[:n]
        return found

    def _analysed(self) -> Iterator[int]:
        """Analyse the block and decide where compiled code leaves it to Python; yield the samples with a decision."""
        while outcome := self._analyse():
            if outcome == CHANGED:
                yield int(self._state.block.next[0]) - 1
            elif outcome < 0:
                self._bit.decide(-outcome)
                self._flow.decided[0] = 1
            else:
                self._decisions.decide[outcome]()
                self._flow.decided[0] = 1

    def _present(self, stamp: int | None = None) -> Findings:
        """Findings at a stamp [ns]; None: after the last sample that was accepted."""
        if self._flow.new[0]:
            self.findings = self._new_findings()
        stamp = self._state.clock.last.item() if stamp is None else stamp
        bit = self._bit
        self.findings = replace(
            self.findings, stamp_ns=stamp, time_s=stamp * 1e-9, orbit_radius=self._radius.copy(), quality=self.quality,
            bit=bit.motion, bit_criterion=bit.criterion, bit_index=bit.index,
        )  # fmt: skip
        return self.findings

    def _check(
        self, stamps: Integers, position: FloatArray, spin: FloatArray | None, wall_force: FloatArray | None
    ) -> None:
        n, m = len(stamps), len(self.marks)
        expected = (
            ("positions", position, ((n, m, 3), (n, m, 2))), ("spin", spin, ((n, m),)),
            ("wall force", wall_force, ((n, m),)),
        )  # fmt: skip
        for name, values, shapes in expected:
            if values is not None and values.shape not in shapes:
                raise AnalysisError(
                    f"expected {name} of shape {shapes[0][1:]} in each of {n} samples of {m} marks, "
                    f"found {values.shape[1:]} in {len(values)}"
                )
        if (wrong := stamps if stamps.dtype.kind != "i" else stamps[np.abs(stamps) > LARGEST_STAMP]).size:
            raise AnalysisError(
                f"expected stamps in whole nanoseconds of at most {LARGEST_STAMP} ns, 146 years from the epoch, "
                f"found {wrong[0]}"
            )

    def _new_findings(self) -> Findings:
        """The present estimates."""
        state, decisions = self._state, self._decisions
        orbit, states = state.orbit, tuple(STATES[held] for held in state.motion.hysteresis.held.tolist())
        state.flow.new[0] = False
        return Findings(
            stamp_ns=0,
            time_s=0.0,
            marks=self._names,
            orbit_radius=self._radius.copy(),
            precession=orbit.precession.copy(),
            ratio=orbit.ratio.copy(),
            confidence=orbit.confidence.copy(),
            state=states[:-1],
            criterion=tuple(decisions.criterion[:-1]),
            motion=states[-1],
            motion_criterion=decisions.criterion[-1],
            bit=self._bit.motion,
            bit_criterion=self._bit.criterion,
            onset=decisions.onset,
            quality=self.quality,
        )


class BitOnlyAnalyzer:
    """Analysis of the speeds of top drive and bit, sample by sample, where no marks have positions."""

    def __init__(self) -> None:
        self.bit = StickSlip()
        """Stick-slip of the bit."""
        self._clock = new_clock(0)
        self._accepted = self._incomplete = 0

    @property
    def quality(self) -> Quality:
        """Counts of good and bad samples so far."""
        clock, revolutions = self._clock, self._clock.revolutions.item()
        rate = self._accepted / revolutions if revolutions > 0.0 else math.nan
        skipped = clock.duplicate.item(), clock.late.item(), self._incomplete
        return Quality(self._accepted, *skipped, samples_per_revolution=rate)

    def push(self, stamp_ns: int, top_speed: float, bit_speed: float) -> bool:
        """Add a sample at a header stamp [ns], speeds in [rad/s]; return whether the motion of the bit changed."""
        clock = self._clock
        if not _IS_NEW(clock, stamp_ns):
            return False
        if not (math.isfinite(top_speed) or math.isfinite(bit_speed)):
            self._incomplete += 1
            return False
        _ROTATE(clock, _ACCEPT(clock, stamp_ns), top_speed, clock.spin, has_spin=False)
        self._accepted += 1
        before = self.bit.motion
        self.bit.push(stamp_ns * 1e-9, bit_speed, top_speed)
        return self.bit.motion is not before

    def summary(self) -> Summary:
        """The findings so far."""
        seconds = as_python(seconds_of)(self._clock)
        return Summary(
            rotation_rev_s=self._clock.angle.item() / math.tau / seconds if seconds > 0.0 else None,
            stick_slip=tuple(self.bit.periods),
            bit=self.bit.motion,
            stick_slip_index=number_or_none(self.bit.index),
            largest_stick_slip_index=number_or_none(self.bit.largest_index),
            quality=self.quality,
            notes=(NOT_OBSERVABLE,),
            observable=False,
        )
