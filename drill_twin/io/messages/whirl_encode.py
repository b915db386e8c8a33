# SPDX-License-Identifier: Apache-2.0
"""Encoding and decoding of `/whirl/state`, `/whirl/motion` and `/whirl/onset`, bit for bit.

Arguments are plain arrays and strings: this module does not depend on the whirl analysis.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from drill_twin.core.arrays import Array
from drill_twin.core.errors import MessageError
from drill_twin.io.messages.cdr import JointStateTemplate, check_not_infinite
from drill_twin.io.messages.decode import JointArrays
from drill_twin.io.messages.diagnostics import Level, Status, decode_diagnostics, encode_diagnostics
from drill_twin.io.messages.stamps import NANOSECONDS, header, header_stamp, seconds, stamp_ns, time_message
from drill_twin.io.messages.topic_row import TIME_REFERENCE
from drill_twin.io.messages.topics import FRAME_ID, WHIRL_STATE
from drill_twin.io.messages.type_store import deserialize, message, serialize

WHIRL_SCALARS = ("orbit_radius", "precession", "ratio", "confidence", "motion")
"""Radius of the centre line's orbit [m], precession [rad/s] (positive = forward), whirl ratio, confidence (0 to 1), and
code of the motion state (`drill_twin.whirl.MotionCode`)."""
STRING_LEVEL = "string"
"""Subject of the whole string on `/whirl/motion`."""

_MOTION = "motion: "


@dataclass(frozen=True)
class SubjectMotion:
    """Motion state of one mark or of the string."""

    subject: str
    """Mark, or `string`."""
    state: str
    """Motion state, as `forward whirl`."""
    criterion: str
    """Criterion that decided the state, as a sentence."""


class OnsetMessage(NamedTuple):
    """Onset of whirl."""

    time: float
    """Simulated time [s]."""
    mark: str
    """First mark that whirled."""


class WhirlStateEncoder:
    """Encoder of `/whirl/state` for marks with fixed names."""

    def __init__(self, marks: Sequence[str], frame_id: str = FRAME_ID) -> None:
        names = [f"{mark}/{scalar}" for mark in marks for scalar in WHIRL_SCALARS]
        self._template = JointStateTemplate(names, velocity=False, effort=False, frame_id=frame_id)

    def rows(self, stamps: Sequence[int], values: Array) -> list[bytes]:
        """CDR of a `/whirl/state` at each stamp [ns].

        Args:
            stamps: Header stamps [ns], n of them.
            values: `WHIRL_SCALARS` of each mark, NaN for what is not known, shape (n, m, 5).

        Raises:
            MessageError: A value is infinite.
        """
        check_not_infinite(WHIRL_STATE, values)
        return self._template.rows(stamps, values)


def read_whirl_state(states: JointArrays) -> tuple[tuple[str, ...], Array]:
    """Names of m marks, and `WHIRL_SCALARS` of each, shape (..., m, 5), of a `/whirl/state` or of several.

    Raises:
        MessageError: The names are not the names of a `/whirl/state`.
    """
    marks = tuple(name.removesuffix("/orbit_radius") for name in states.names if name.endswith("/orbit_radius"))
    if states.names != tuple(f"{mark}/{scalar}" for mark in marks for scalar in WHIRL_SCALARS):
        raise MessageError(
            f"expected the joints <mark>/{', <mark>/'.join(WHIRL_SCALARS)} of a /whirl/state, "
            f"found {', '.join(states.names) or 'none'}"
        )
    return marks, states.position.reshape(*states.position.shape[:-1], len(marks), len(WHIRL_SCALARS))


def encode_motion(stamp: int, motions: Sequence[SubjectMotion], frame_id: str = FRAME_ID, onset: str = "") -> bytes:
    """CDR of `/whirl/motion` at a stamp [ns].

    Args:
        stamp: Header stamp [ns].
        motions: Motion states, the string's first.
        frame_id: Frame of the samples.
        onset: Sentence on the onset, for the string; empty before it.
    """
    statuses = [
        Status(
            name=_MOTION + motion.subject,
            level=Level.OK,
            text=motion.state,
            values={"criterion": motion.criterion} | ({"onset": onset} if onset and not place else {}),
            hardware_id=motion.subject,
        )
        for place, motion in enumerate(motions)
    ]
    return encode_diagnostics(stamp, statuses, frame_id)


def decode_motion(raw: bytes) -> tuple[int, list[SubjectMotion]]:
    """Stamp [ns] and motion states of a `/whirl/motion`.

    Raises:
        MessageError: Not a `/whirl/motion`.
    """
    stamp, statuses = decode_diagnostics(raw)
    motions = []
    for status in statuses:
        if not status.name.startswith(_MOTION):
            raise MessageError(f"expected {_MOTION}<mark> in a /whirl/motion, found {status.name!r}")
        motions.append(
            SubjectMotion(status.name.removeprefix(_MOTION), status.text, status.values.get("criterion", ""))
        )
    return stamp, motions


def encode_onset(stamp: int, onset: OnsetMessage | None, frame_id: str = FRAME_ID) -> bytes:
    """CDR of `/whirl/onset`, announced at a stamp [ns]; None before the onset.

    An onset at time zero is one nanosecond later, since zero says that there is none.
    """
    time, mark = (0, "") if onset is None else (max(stamp_ns(onset.time), 1), onset.mark)
    content = message(TIME_REFERENCE, header=header(stamp, frame_id), time_ref=time_message(time), source=mark)
    return serialize(content, TIME_REFERENCE)


def decode_onset(raw: bytes) -> tuple[int, OnsetMessage | None]:
    """Stamp [ns] and onset of a `/whirl/onset`; None before the onset.

    Raises:
        MessageError: Not a `/whirl/onset`.
    """
    content = deserialize(raw, TIME_REFERENCE)
    time = int(content.time_ref.sec) * NANOSECONDS + int(content.time_ref.nanosec)
    return header_stamp(content), OnsetMessage(seconds(time), content.source) if time else None
