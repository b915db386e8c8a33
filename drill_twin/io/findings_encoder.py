# SPDX-License-Identifier: Apache-2.0
"""Encoding of the analyzer's findings to `/whirl/state`, `/whirl/motion`, `/whirl/onset` and `/twin/summary`.

The summary is what a dashboard wants, five times a simulated second, as numbers without NaN.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.io.messages.cdr import JointStateTemplate, finite_number
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.io.messages.topics import FRAME_ID, TWIN_SUMMARY, WHIRL_MOTION, WHIRL_ONSET, WHIRL_STATE
from drill_twin.io.messages.whirl_encode import (
    STRING_LEVEL,
    OnsetMessage,
    SubjectMotion,
    WhirlStateEncoder,
    encode_motion,
    encode_onset,
)
from drill_twin.io.samples import UNKNOWN_RIG, RigSample
from drill_twin.whirl import BitMotion, MarkInfo, MotionCode, MotionState, Onset, StickSlip, StickSlipCode
from drill_twin.whirl.analyzer import NOT_OBSERVABLE
from drill_twin.whirl.findings import Findings, FoundRows

PERIOD = NANOSECONDS // 5
"""Simulated time between two messages [ns]."""
_RIG = ("rate_of_penetration", "weight_on_bit", "rotation")
_FINDINGS = ("whirl", "whirl_severity", "stick_slip", "stick_slip_severity", "onset", "realtime_factor")


class Motion(NamedTuple):
    """Motion at an instant."""

    string: MotionState
    """Motion state of the string."""
    radius: Array
    """Radius of the orbit of each mark [m], shape (m,)."""
    bit: BitMotion
    """Motion of the bit."""
    bit_index: float
    """Stick-slip index; NaN where it is not known."""
    onset: Onset | None = None
    """Onset so far."""


class TwinSummary:
    """Collects samples, and encodes their means with the findings of the last one.

    A value of the rig that the first sample does not have is left out of all messages; a value that only later
    samples lack stays.
    """

    def __init__(self, marks: Sequence[MarkInfo]) -> None:
        """Begin without samples of these marks."""
        self._clearance = np.array([math.inf if mark.inclined else mark.clearance for mark in marks])
        self._factor = 0.0  # before the first is told
        self._due = -1
        self._samples: list[RigSample] = []
        self._begin = (0, math.nan)  # stamp and depth of the last message
        self._rig: dict[str, float] = {}
        self._template: JointStateTemplate | None = None
        self._frame_id = FRAME_ID

    def take_factor(self, factor: float) -> None:
        """Take the real-time factor of the simulator.

        Raises:
            MessageError: The factor is not finite.
        """
        self._factor = finite_number(TWIN_SUMMARY, "real-time factor", factor)

    def add(self, stamp: int, rig: RigSample) -> bool:
        """Add a sample at a stamp [ns]; returns whether a message is due, by `encode`."""
        self._samples.append(rig)
        return stamp >= self._due

    def encode(self, stamp: int, motion: Motion, frame_id: str) -> bytes:
        """CDR of the message at the stamp [ns] of the last sample.

        Args:
            stamp: Header stamp [ns].
            motion: What the analysis finds then.
            frame_id: Frame of the samples.
        """
        self._due = stamp - stamp % PERIOD + PERIOD
        self._mean_of_rig(stamp)
        whirl, share = MotionCode.of(motion.string), motion.radius / self._clearance
        values = (
            whirl,
            np.nanmax(share, initial=0.0) if whirl.whirls else 0.0,
            StickSlipCode.of(motion.bit),
            motion.bit_index if math.isfinite(motion.bit_index) else 0.0,
            0.0 if motion.onset is None else max(motion.onset.time_s, 1.0 / NANOSECONDS),
            self._factor,
        )
        if self._template is None or frame_id != self._frame_id:
            names = (*self._rig, *_FINDINGS)
            self._template = JointStateTemplate(names, velocity=False, effort=False, frame_id=frame_id)
            self._frame_id = frame_id
        return self._template.fill(stamp, (*self._rig.values(), *values))

    def _mean_of_rig(self, stamp: int) -> None:
        """Mean weight and rotation of the samples since the last message, and the rate at which the depth grew."""
        samples, self._samples = np.array(self._samples), []
        begin, before = self._begin
        depth = float(samples[-1, 3])
        self._begin = (stamp, depth)
        rate = (depth - before) / seconds(stamp - begin) if stamp > begin else math.nan
        weight, rotation = (_mean(samples[:, column]) for column in (2, 0))
        if self._template is None:
            rate = 0.0 if math.isfinite(depth) else math.nan
        now = dict(zip(_RIG, (rate, weight, rotation), strict=True))
        known = {name: value for name, value in now.items() if math.isfinite(value)}
        self._rig = known if self._template is None else {name: known.get(name, self._rig[name]) for name in self._rig}


def _mean(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else math.nan


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
        return self.rows(FoundRows.of(findings), frame_id, [rig or UNKNOWN_RIG])[0]

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
    return f"whirl began at {onset.time_s:.2f} s{error} at {onset.mark}{undated}"


def _motions(findings: Findings) -> list[SubjectMotion]:
    marks = zip(findings.marks, findings.state, findings.criterion, strict=True)
    return [
        SubjectMotion(STRING_LEVEL, findings.motion.value, findings.motion_criterion),
        *(SubjectMotion(mark, state.value, criterion) for mark, state, criterion in marks),
        SubjectMotion(BIT, findings.bit.value, findings.bit_criterion),
    ]
