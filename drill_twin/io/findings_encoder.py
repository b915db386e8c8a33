# SPDX-License-Identifier: Apache-2.0
"""Encoding of the analyzer's findings to `/whirl/state`, `/whirl/motion`, `/whirl/onset` and `/twin/summary`.

The summary is what a dashboard wants, five times a simulated second, as numbers without NaN.
"""

import math
from collections import deque
from collections.abc import Iterator, Sequence

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.severity import DEFAULT, Bounds, Grade, worst
from drill_twin.io.messages.cdr import JointStateTemplate, finite_number
from drill_twin.io.messages.diagnostics import Level
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
from drill_twin.io.samples import RigSample
from drill_twin.whirl import BitMotion, MarkInfo, MotionCode, MotionState, Onset, StickSlip, StickSlipCode
from drill_twin.whirl.analyzer import NOT_OBSERVABLE
from drill_twin.whirl.findings import Findings, FoundRows
from drill_twin.whirl.motion.stick_slip_index import TIME_BASE
from drill_twin.whirl.severity import WINDOW, accelerations, sizes, torsion_grade, turns_backwards

PERIOD = NANOSECONDS // 5
"""Simulated time between two messages [ns]."""
_RIG = ("rate_of_penetration", "weight_on_bit", "rotation")
_FINDINGS = (
    "whirl", "stick_slip", "stick_slip_severity", "severity", "lateral_severity", "onset", "realtime_factor",
)  # fmt: skip
LATERAL = ("lateral_rms", "lateral_peak")
"""Quantities of `core.severity.Bounds`, each with a `/` and the name of a mark in the summary [m/s^2]."""
UNKNOWN = -1.0
"""Grade, or acceleration, that is not known: the summary has no NaN."""


class TwinSummary:
    """Collects samples, and encodes their means with the findings of the last one.

    A value of the rig that the first sample does not have is left out of all messages; a value that only later
    samples lack stays.
    """

    def __init__(self, marks: Sequence[MarkInfo], bounds: Bounds | None = None) -> None:
        """Begin without samples of these marks; `bounds` of the grades of severity are by default of this program."""
        self._marks, self._bounds = [mark.name for mark in marks], bounds or DEFAULT
        self._centres: deque[tuple[int, ComplexArray]] = deque()  # stamps, and centre lines in the last `WINDOW`
        self._backwards = -math.inf  # time at which the bit turned backwards last [s]
        self.grade: Grade | None = None
        """Severity of the last message, of what is known of it."""
        self._factor = 0.0  # before the first is told
        self._due = -1
        self._samples: list[RigSample | Array] = []
        self._begin = (0, math.nan)  # stamp and depth of the last message
        self._rig: dict[str, float] = {}
        self._template: JointStateTemplate | None = None
        self._frame_id = FRAME_ID

    def set_factor(self, factor: float) -> None:
        """Set the real-time factor of the simulator.

        Raises:
            MessageError: The factor is not finite.
        """
        self._factor = finite_number(TWIN_SUMMARY, "real-time factor", factor)

    def add(self, stamp: int, rig: RigSample | Array, centre: ComplexArray | None = None) -> bool:
        """Add a sample at a stamp [ns]; returns whether a message is due, by `encode`.

        Args:
            stamp: Header stamp [ns].
            rig: State of the rig, fields of `RigSample`.
            centre: Centre line at the marks [m], shape (m,); None where it is not known. Of a stamp that is not later
                than the last, it is left out.
        """
        self._samples.append(rig)
        if centre is not None and (not self._centres or stamp > self._centres[-1][0]):
            self._centres.append((stamp, centre))
        if turns_backwards(rig[1], rig[0]):
            self._backwards = seconds(stamp)
        return stamp >= self._due

    def encode(
        self, stamp: int, frame_id: str, string: MotionState, bit: BitMotion, index: float, onset: Onset | None = None
    ) -> bytes:
        """CDR of the message at the stamp [ns] of the last sample.

        Args:
            stamp: Header stamp [ns].
            frame_id: Frame of the samples.
            string: Motion state of the string.
            bit: Motion of the bit.
            index: Stick-slip index; NaN where it is not known.
            onset: Onset so far.
        """
        self._due = stamp - stamp % PERIOD + PERIOD
        self._mean_of_rig(stamp)
        backwards = seconds(stamp) - self._backwards <= TIME_BASE
        torsion = torsion_grade(bit, index, self._bounds, backwards=backwards)
        found = self._lateral(stamp, string)
        lateral = worst(found, self._bounds)
        self.grade = max((grade for grade in (torsion, lateral and lateral.grade) if grade is not None), default=None)
        values = (
            *(value if math.isfinite(value) else UNKNOWN for _, value, _ in found),
            MotionCode.of(string),
            StickSlipCode.of(bit),
            index if math.isfinite(index) else 0.0,
            UNKNOWN if self.grade is None else self.grade,
            UNKNOWN if lateral is None else lateral.grade,
            0.0 if onset is None else max(onset.time_s, 1.0 / NANOSECONDS),
            self._factor,
        )
        if self._template is None or frame_id != self._frame_id:
            names = (*self._rig, *(f"{quantity}/{mark}" for quantity, _, mark in found), *_FINDINGS)
            self._template = JointStateTemplate(names, velocity=False, effort=False, frame_id=frame_id)
            self._frame_id = frame_id
        return self._template.fill(stamp, (*self._rig.values(), *values))

    def _lateral(self, stamp: int, string: MotionState) -> list[tuple[str, float, str]]:
        """Quantity, value [m/s^2] and mark of the lateral accelerations in the last `WINDOW`; NaN where not known."""
        while self._centres and seconds(stamp - self._centres[0][0]) > WINDOW:
            self._centres.popleft()
        time = np.array([seconds(at) for at, _ in self._centres])
        centres = np.array([centre for _, centre in self._centres]).reshape(time.size, len(self._marks))
        _, found = accelerations(time, centres)
        if string is MotionState.NOT_OBSERVABLE:
            found = found[:0]
        return [
            (quantity, value, mark)
            for column, mark in enumerate(self._marks)
            for quantity, value in zip(LATERAL, sizes(found[:, column]), strict=True)
        ]

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

    def __init__(self, marks: Sequence[MarkInfo], bounds: Bounds | None = None) -> None:
        self._names = [mark.name for mark in marks]
        self.summary = TwinSummary(marks, bounds)
        """Messages on `/twin/summary`."""
        self._state, self._frame_id = WhirlStateEncoder(self._names), FRAME_ID
        self._motion: tuple[object, ...] = ()
        self._motion_due = -1
        self.onset_announced = False
        """True once an onset was encoded."""

    @property
    def severity(self) -> tuple[Level, str]:
        """Level of the diagnostics, WARN from high on as the dashboard's alarm, and the severity as a word."""
        grade = self.summary.grade
        bad = grade is not None and grade >= Grade.HIGH
        return Level.WARN if bad else Level.OK, "unknown" if grade is None else grade.word

    @staticmethod
    def no_onset(stamp: int = 0) -> tuple[str, bytes]:
        """Topic and bytes of `/whirl/onset` without an onset, to publish before the first sample."""
        return WHIRL_ONSET, encode_onset(stamp, None)

    @staticmethod
    def bit_only(stamp: int, bit: StickSlip) -> tuple[str, bytes]:
        """Topic and bytes of `/whirl/motion` for a stream without marks."""
        whirl = SubjectMotion(STRING_LEVEL, BitMotion.UNKNOWN.value, NOT_OBSERVABLE)
        return WHIRL_MOTION, encode_motion(stamp, [whirl, SubjectMotion(BIT, bit.motion.value, bit.criterion)])

    def bit_summary(self, stamp: int, bit: StickSlip, rig: RigSample) -> list[tuple[str, bytes]]:
        """Topic and bytes of `/twin/summary` for a stream without marks, if it is due."""
        if not self.summary.add(stamp, rig):
            return []
        string = MotionState.NOT_OBSERVABLE
        return [(TWIN_SUMMARY, self.summary.encode(stamp, self._frame_id, string, bit.motion, bit.index))]

    def rows(
        self,
        found: FoundRows,
        frame_id: str = FRAME_ID,
        rigs: Array | None = None,
        centres: ComplexArray | None = None,
    ) -> list[list[tuple[str, bytes]]]:
        """Topics and bytes of the messages for the findings after each of n samples.

        Args:
            found: The findings.
            frame_id: Frame of the samples.
            rigs: Fields of `RigSample`, shape (n, 4); None: no `/twin/summary`.
            centres: Centre lines at the marks [m], shape (n, m); None where they are not known.
        """
        self._set_frame(frame_id)
        messages = [[(WHIRL_STATE, raw)] for raw in self._state.rows(found.stamps, found.states())]
        present = found.before
        for row, stamp in enumerate(found.stamps):
            if row in found.changes or stamp >= self._motion_due:
                present = found.changes.get(row, present)
                messages[row] += self._on_change(stamp, present)
            if rigs is not None and self.summary.add(stamp, rigs[row], None if centres is None else centres[row]):
                index = float(found.bit_index[row])
                raw = self.summary.encode(stamp, self._frame_id, present.motion, present.bit, index, present.onset)
                messages[row].append((TWIN_SUMMARY, raw))
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
