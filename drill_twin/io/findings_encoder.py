# SPDX-License-Identifier: Apache-2.0
"""Encoding of the analyzer's findings to `/whirl/state`, `/whirl/motion` and `/whirl/onset`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.io.messages.topics import FRAME_ID, TWIN_SUMMARY, WHIRL_MOTION, WHIRL_ONSET, WHIRL_STATE
from drill_twin.io.messages.whirl_encode import (
    STRING_LEVEL,
    WHIRL_SCALARS,
    OnsetMessage,
    SubjectMotion,
    WhirlStateEncoder,
    encode_motion,
    encode_onset,
)
from drill_twin.io.twin_summary import UNKNOWN_RIG, Motion, RigSample, TwinSummary
from drill_twin.whirl import BitMotion, MarkInfo, MotionState, Onset, StickSlip
from drill_twin.whirl.bit_only_analyzer import NOT_OBSERVABLE
from drill_twin.whirl.findings import Findings, FoundRows

BIT = "bit"
"""Name under which `/whirl/motion` reports the rotation of the bit: steady, torsional vibration, stick-slip."""

_LONGEST_FRAME = 255  # letters; a longer name of a frame is not copied into every message


class FindingsEncoder:
    """Encodes findings: `/whirl/state` for each, `/whirl/motion` on change and once a simulated second."""

    def __init__(self, marks: Sequence[MarkInfo]) -> None:
        self._names = [mark.name for mark in marks]
        self.summary = TwinSummary(marks)
        """Messages on `/twin/summary`."""
        self._state, self._frame_id = WhirlStateEncoder(self._names), FRAME_ID
        self._values = np.empty((len(marks), len(WHIRL_SCALARS)))
        self._motion: tuple[object, ...] = ()
        self._motion_due = -1
        self.onset_announced = False
        """True once an onset was encoded."""

    @staticmethod
    def no_onset(stamp: int = 0) -> tuple[str, bytes]:
        """Topic and bytes of `/whirl/onset` without an onset, to publish before the first sample."""
        return WHIRL_ONSET, encode_onset(stamp, None)

    @staticmethod
    def bit_only(stamp: int, bit: StickSlip) -> tuple[str, bytes]:
        """Topic and bytes of `/whirl/motion` for a stream without marks."""
        whirl = SubjectMotion(STRING_LEVEL, BitMotion.UNKNOWN.value, NOT_OBSERVABLE)
        return WHIRL_MOTION, encode_motion(stamp, [whirl, SubjectMotion(BIT, bit.motion.value, bit.criterion)])

    def messages(
        self, findings: Findings, frame_id: str = FRAME_ID, rig: RigSample | None = None
    ) -> list[tuple[str, bytes]]:
        """Topics and bytes of the messages for these findings, in the frame of the samples, and the rig's state."""
        self._set_frame(frame_id)
        stamp, columns = findings.stamp_ns, self._values.T
        columns[0], columns[1] = findings.orbit_radius, math.tau * findings.precession
        columns[2], columns[3], columns[4] = findings.ratio, findings.confidence, findings.codes
        messages = [(WHIRL_STATE, self._state.encode(stamp, self._values)), *self._on_change(stamp, findings)]
        if self.summary.add(stamp, rig or UNKNOWN_RIG):
            messages.append(self._summary(stamp, findings, findings.orbit_radius, findings.bit_index))
        return messages

    def _summary(self, stamp: int, findings: Findings, radius: Array, bit_index: float) -> tuple[str, bytes]:
        motion = Motion(findings.motion, radius, findings.bit, bit_index, findings.onset)
        return TWIN_SUMMARY, self.summary.encode(stamp, motion, self._frame_id)

    def bit_summary(self, stamp: int, bit: StickSlip, rig: RigSample) -> list[tuple[str, bytes]]:
        """Topic and bytes of `/twin/summary` for a stream without marks, if it is due."""
        if not self.summary.add(stamp, rig):
            return []
        motion = Motion(MotionState.NOT_OBSERVABLE, np.zeros(len(self._names)), bit.motion, bit.index)
        return [(TWIN_SUMMARY, self.summary.encode(stamp, motion, self._frame_id))]

    def rows(
        self, found: FoundRows, frame_id: str = FRAME_ID, rigs: Sequence[RigSample] | None = None
    ) -> list[list[tuple[str, bytes]]]:
        """As `messages`, for each of several samples; without states of the rig no `/twin/summary`."""
        self._set_frame(frame_id)
        messages = [[(WHIRL_STATE, raw)] for raw in self._state.rows(found.stamps, found.states())]
        present = found.before
        for row, stamp in enumerate(found.stamps):
            if row in found.changes or stamp >= self._motion_due:
                present = found.changes.get(row, present)
                messages[row] += self._on_change(stamp, present)
            if rigs is not None and self.summary.add(stamp, rigs[row]):
                radius, index = found.values[row, :, 0], float(found.bit_index[row])
                messages[row].append(self._summary(stamp, present, radius, index))
        return messages

    def _set_frame(self, frame_id: str) -> None:
        if frame_id != self._frame_id and len(frame_id) <= _LONGEST_FRAME:
            self._state, self._frame_id = WhirlStateEncoder(self._names, frame_id), frame_id

    def _on_change(self, stamp: int, findings: Findings) -> Iterator[tuple[str, bytes]]:
        """Motion where it has changed or a second is over, and the onset once."""
        motion = (findings.motion, findings.bit, *findings.state)
        if motion != self._motion or stamp >= self._motion_due:
            self._motion, self._motion_due = motion, stamp - stamp % NANOSECONDS + NANOSECONDS
            yield WHIRL_MOTION, encode_motion(stamp, _motions(findings), self._frame_id, _sentence(findings.onset))
        if findings.onset is not None and not self.onset_announced:
            self.onset_announced = True
            onset = OnsetMessage(findings.onset.time_s, findings.onset.mark)
            yield WHIRL_ONSET, encode_onset(stamp, onset, self._frame_id)


def _sentence(onset: Onset | None) -> str:
    if onset is None:
        return ""
    error = "" if onset.uncertainty_s is None else f", within {onset.uncertainty_s:.2g} s"
    undated = "" if onset.dated else "; its time is not known within a revolution"
    return f"whirl began at {onset.time_s:.2f} s{error} at {onset.mark}, confidence {onset.confidence:.2f}{undated}"


def _motions(findings: Findings) -> list[SubjectMotion]:
    marks = zip(findings.marks, findings.state, findings.criterion, strict=True)
    return [
        SubjectMotion(STRING_LEVEL, findings.motion.value, findings.motion_criterion),
        *(SubjectMotion(mark, state.value, criterion) for mark, state, criterion in marks),
        SubjectMotion(BIT, findings.bit.value, findings.bit_criterion),
    ]
