# SPDX-License-Identifier: Apache-2.0
"""Encoding of the analyzer's findings to `/whirl/state`, `/whirl/motion` and `/whirl/onset`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.io.messages.topics import FRAME_ID, WHIRL_MOTION, WHIRL_ONSET, WHIRL_STATE
from drill_twin.io.messages.whirl_encode import (
    STRING_LEVEL,
    OnsetMessage,
    SubjectMotion,
    WhirlStateEncoder,
    encode_motion,
    encode_onset,
)
from drill_twin.whirl import BitMotion, MarkInfo, StickSlip
from drill_twin.whirl.bit_only_analyzer import NOT_OBSERVABLE
from drill_twin.whirl.findings import Findings, FoundRows

BIT = "bit"
"""Name under which `/whirl/motion` reports the rotation of the bit: steady, torsional vibration, stick-slip."""

_LONGEST_FRAME = 255  # letters; a longer name of a frame is not copied into every message


class FindingsEncoder:
    """Encodes findings: `/whirl/state` for each, `/whirl/motion` on change and once a simulated second."""

    def __init__(self, marks: Sequence[MarkInfo]) -> None:
        self._names = [mark.name for mark in marks]
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

    def messages(self, findings: Findings, frame_id: str = FRAME_ID) -> Iterator[tuple[str, bytes]]:
        """Topics and bytes of the messages for these findings, in the frame of the samples."""
        self._set_frame(frame_id)
        yield (
            WHIRL_STATE,
            self._state.encode(
                findings.stamp_ns, findings.orbit_radius, findings.precession, findings.ratio, findings.confidence
            ),
        )
        yield from self._on_change(findings.stamp_ns, findings)

    def rows(self, found: FoundRows, frame_id: str = FRAME_ID) -> list[list[tuple[str, bytes]]]:
        """As `messages`, for each of several samples."""
        self._set_frame(frame_id)
        messages = [[(WHIRL_STATE, raw)] for raw in self._state.rows(found.stamps, found.values)]
        present = found.before
        for row, stamp in enumerate(found.stamps):
            if row in found.changes or stamp >= self._motion_due:
                present = found.changes.get(row, present)
                messages[row] += self._on_change(stamp, present)
        return messages

    def _set_frame(self, frame_id: str) -> None:
        if frame_id != self._frame_id and len(frame_id) <= _LONGEST_FRAME:
            self._state, self._frame_id = WhirlStateEncoder(self._names, frame_id), frame_id

    def _on_change(self, stamp: int, findings: Findings) -> Iterator[tuple[str, bytes]]:
        """Motion where it has changed or a second is over, and the onset once."""
        motion = (findings.motion, findings.bit, *findings.state)
        if motion != self._motion or stamp >= self._motion_due:
            self._motion, self._motion_due = motion, stamp - stamp % NANOSECONDS + NANOSECONDS
            yield WHIRL_MOTION, encode_motion(stamp, _motions(findings), self._frame_id)
        if findings.onset is not None and not self.onset_announced:
            self.onset_announced = True
            onset = findings.onset
            message = OnsetMessage(onset.time_s, onset.mark, onset.confidence, onset.uncertainty_s, onset.dated)
            yield WHIRL_ONSET, encode_onset(stamp, message, self._frame_id)


def _motions(findings: Findings) -> list[SubjectMotion]:
    marks = zip(findings.marks, findings.state, findings.criterion, strict=True)
    return [
        SubjectMotion(STRING_LEVEL, findings.motion.value, findings.motion_criterion),
        *(SubjectMotion(mark, state.value, criterion) for mark, state, criterion in marks),
        SubjectMotion(BIT, findings.bit.value, findings.bit_criterion),
    ]
