# SPDX-License-Identifier: Apache-2.0
"""Classification of the motion of each mark and of the string by `Criteria` into `MotionState`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drill_twin.base.arrays import Array, Mask
from drill_twin.whirl.criteria import Criteria, MotionState
from drill_twin.whirl.marks import MarkInfo
from drill_twin.whirl.motion.irregularity import Irregularity
from drill_twin.whirl.motion.state_hysteresis import StateHysteresis
from drill_twin.whirl.motion.timeline import NO_WHIRL
from drill_twin.whirl.orbit.orbit import Orbit
from drill_twin.whirl.orbit.string_shape import StringShape
from drill_twin.whirl.text import criterion_text

LONGEST_DELAY = 8.0
"""Largest shift of the start of irregular motion into the past, over half the window."""


class MotionClassifier:
    """Motion state of each mark and, last, of the string."""

    def __init__(self, infos: Sequence[MarkInfo], criteria: Criteria) -> None:
        marks = len(infos)
        self._criteria = criteria
        self._rolling_ratio = np.array([info.rolling_ratio for info in infos])
        self.hysteresis = StateHysteresis(marks + 1, criteria)
        self._every = np.arange(marks)
        self._irregularity = Irregularity(marks, criteria)
        self._in_contact: Mask = np.zeros(marks, bool)
        self._still: Mask = np.zeros(marks, bool)
        self._dated: list[float | None] = [None] * (marks + 1)  # begin of the whirl of each subject that has a period
        self._rolls: Mask = np.zeros(marks, bool)  # the contact point slips little, if there is contact
        self._helical = self._two_sided = False

    def update(
        self,
        orbit: Orbit,
        shape: StringShape,
        whirling: tuple[Mask, Mask],
        began: Sequence[float | None],
        detected: Array,
        ratio: Array,
        at: tuple[float, float, float],
    ) -> None:
        """Estimate the states and apply the hysteresis.

        Args:
            orbit: Orbits of the marks.
            shape: Shape of the string.
            whirling: Marks in asynchronous and in synchronous whirl, shape (m,) each.
            began: Start of the whirl of each mark [s].
            detected: Detection of the asynchronous whirl of each mark [rev], shape (m,).
            ratio: Precession over rotation, shape (m,).
            at: Time [s] and revolutions [rev] since the first sample, and the time of the first sample [s].
        """
        time, revolutions, origin = at
        self._update_flags(orbit, shape, whirling[0], detected, ratio, at)
        whirls = whirling[0] | whirling[1]
        estimates = self._of_marks(orbit, whirls, ratio)
        reference = self._reference_mark(orbit, shape, whirls)
        estimates.append(self._of_string(estimates[reference]))
        marks = [*range(self._every.size), reference]
        began = [*began, min((start for start in began if start is not None), default=None)]
        starts = [
            self._start(subject, marks[subject], estimate, start, orbit.lag, time)
            for subject, (estimate, start) in enumerate(zip(estimates, began, strict=True))
        ]
        changed, settled = self.hysteresis.update(estimates, starts, orbit.lag, time, revolutions)
        for subject in changed:
            if self.hysteresis.states[subject] not in NO_WHIRL:
                self._dated[subject] = began[subject]
        for subject in (*changed, *settled):
            mark = marks[subject]
            row = 0 if whirling[0][mark] else 1
            state = self.hysteresis.states[subject]
            text = criterion_text(state, orbit, shape, self._criteria, mark, row, float(ratio[mark]))
            if subject in settled:
                self.hysteresis.describe(subject, text)
            else:
                self.hysteresis.enter(subject, text, origin)

    @staticmethod
    def _reference_mark(orbit: Orbit, shape: StringShape, whirls: Mask) -> int:
        """Mark whose state the string takes: the whirling mark with the largest motion, if any whirls."""
        whirls = whirls & orbit.seen
        reference = int(np.argmax(np.where(whirls, shape.power, -1.0))) if whirls.any() else shape.reference
        if not orbit.seen[reference]:
            reference = int(np.argmax(np.where(orbit.seen, shape.power, -1.0)))
        return reference

    def _start(
        self, subject: int, mark: int, estimate: MotionState, began: float | None, lag: float, time: float
    ) -> float | None:
        """Start of the estimated state [s], where it is known better than from the hysteresis."""
        held = self.hysteresis.states[subject]
        if held in NO_WHIRL:
            # A whirl goes on after the string stood for a while; its begin is that of its first period.
            return None if estimate in NO_WHIRL or began == self._dated[subject] else began
        if estimate is MotionState.IRREGULAR:
            return max(float(self._irregularity.rose[mark]), time - LONGEST_DELAY * lag) - lag
        if held is MotionState.IRREGULAR and estimate not in NO_WHIRL:
            # The last irregular window ends up to a window, two lags, after the change.
            return max(float(self._irregularity.last[mark]), time - LONGEST_DELAY * lag) - 1.5 * lag
        return None

    def _update_flags(
        self,
        orbit: Orbit,
        shape: StringShape,
        asynchronous: Mask,
        detected: Array,
        ratio: Array,
        at: tuple[float, float, float],
    ) -> None:
        """Update the criteria that have a hysteresis of their own."""
        criteria = self._criteria
        row = np.where(asynchronous, 0, 1)
        coherence = orbit.coherence[row, self._every]
        unevenness = orbit.unevenness[row, self._every]
        share = criteria.standing_share
        self._still = (1.0 - coherence < share * (1.0 - criteria.coherence)) & (
            unevenness < share * criteria.unevenness
        )
        self._irregularity.update(coherence, unevenness, at[1] - detected > criteria.settling_time, at[0], at[1])
        self._in_contact = _latched(
            self._in_contact,
            orbit.contact > criteria.contact_fraction,
            orbit.contact < criteria.contact_fraction - criteria.contact_hysteresis,
        )
        slip = self._slip(ratio)
        self._rolls = _latched(self._rolls, slip < criteria.rolling_slip, slip > criteria.rolling_slip + 0.1)
        several = shape.levels > 1
        self._helical = several and shape.planarity < criteria.planar + (0.1 if self._helical else 0.0)
        self._two_sided = several and shape.second_lobe > criteria.lobe - (0.1 if self._two_sided else 0.0)

    def _slip(self, ratio: Array) -> Array:
        """Slip of the contact point over the rim speed; 0 for any backward whirl where the rim is not known."""
        known = np.where(self._rolling_ratio < 0.0, self._rolling_ratio, -1.0)
        slip = np.where(self._rolling_ratio < 0.0, np.abs(1.0 - ratio / known), 0.0)
        result: Array = np.where(ratio < 0.0, slip, np.inf)
        return result

    def _of_marks(self, orbit: Orbit, whirls: Mask, ratio: Array) -> list[MotionState]:
        """Estimated state of each mark."""
        if abs(orbit.recent_rotation) < self._criteria.rest_rotation:
            return [MotionState.AT_REST] * self._every.size
        hidden = np.ones_like(orbit.seen) if orbit.aliased else ~orbit.seen
        stands = (np.abs(ratio) < self._criteria.standing_ratio) & self._still
        flags = (hidden, whirls, self._irregularity.active, stands, self._in_contact & self._rolls, ratio > 0.0)
        return [_state(*mark) for mark in zip(*(flag.tolist() for flag in flags), strict=True)]

    def _of_string(self, reference: MotionState) -> MotionState:
        """Estimated state of the string, from that of its reference mark."""
        if reference in NO_WHIRL or reference is MotionState.IRREGULAR:
            return reference
        if self._helical:
            return MotionState.SPIRAL
        return MotionState.SECOND_BENDING if self._two_sided else reference


def _latched(flag: Mask, on: Mask, off: Mask) -> Mask:
    """A flag with hysteresis: set by `on`, cleared by `off`, kept otherwise."""
    result: Mask = on | (flag & ~off)
    return result


def _state(hidden: bool, whirl: bool, irregular: bool, stands: bool, rolling: bool, forward: bool) -> MotionState:
    """The state of a mark that rotates."""
    if hidden:
        return MotionState.NOT_OBSERVABLE
    if not whirl:
        return MotionState.FIXED_AXIS
    if irregular:
        return MotionState.IRREGULAR
    if stands:
        return MotionState.FIXED_AXIS
    if rolling:
        return MotionState.ROLLING
    return MotionState.FORWARD_WHIRL if forward else MotionState.REVERSE_WHIRL
