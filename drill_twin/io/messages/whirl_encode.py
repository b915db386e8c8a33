# SPDX-License-Identifier: Apache-2.0
"""Encoding and decoding of `/whirl/state`, `/whirl/motion` and `/whirl/onset`, bit for bit.

Arguments are plain arrays and strings: this module does not depend on the whirl analysis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from drill_twin.core.arrays import Array
from drill_twin.core.errors import MessageError
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.decode import JointState
from drill_twin.io.messages.diagnostics import Level, Status, decode_diagnostics, encode_diagnostics, exact
from drill_twin.io.messages.finite import check_not_infinite
from drill_twin.io.messages.topics import FRAME_ID, WHIRL_STATE

WHIRL_SCALARS = ("orbit_radius", "precession", "ratio", "confidence")
STRING_LEVEL = "string"
"""Subject of the whole string on `/whirl/motion`."""

_ONSET = "whirl onset"
_MOTION = "motion: "
_NONE_YET = "no onset so far"


@dataclass(frozen=True, eq=False)
class WhirlOfMarks:
    """Whirl of each mark at one instant, arrays of shape (m,)."""

    stamp: int
    """Header stamp [ns]."""
    marks: tuple[str, ...]
    """Names of the marks."""
    orbit_radius: Array
    """Radius of the centre line's orbit [m]."""
    precession: Array
    """Precession [rev/s], positive = forward."""
    ratio: Array
    """Precession over rotation."""
    confidence: Array
    """Confidence, 0 to 1."""


@dataclass(frozen=True)
class SubjectMotion:
    """Motion state of one mark or of the string."""

    subject: str
    """Mark, or `string`."""
    state: str
    """Motion state, as `forward whirl`."""
    criterion: str
    """Criterion that decided the state, as a sentence."""


@dataclass(frozen=True)
class OnsetMessage:
    """Onset of whirl."""

    time: float
    """Simulated time [s]."""
    mark: str
    """First mark that whirled."""
    confidence: float
    """Confidence, 0 to 1."""
    uncertainty: float | None = None
    """From a downhole sub: how far from it the onset may be [s]."""
    dated: bool = True
    """False where the time is not known within a revolution."""


class WhirlStateEncoder:
    """Encoder of `/whirl/state` for marks with fixed names."""

    def __init__(self, marks: Sequence[str], frame_id: str = FRAME_ID) -> None:
        names = [f"{mark}/{scalar}" for mark in marks for scalar in WHIRL_SCALARS]
        self._template = JointStateTemplate(names, velocity=False, effort=False, frame_id=frame_id)
        self._values = np.empty((len(marks), len(WHIRL_SCALARS)))

    def encode(
        self,
        stamp: int,
        orbit_radius: ArrayLike,
        precession: ArrayLike,
        ratio: ArrayLike,
        confidence: ArrayLike,
    ) -> bytes:
        """CDR of `/whirl/state`.

        Args:
            stamp: Header stamp [ns].
            orbit_radius: Radius of the centre line's orbit [m], shape (m,); NaN where unknown, as all others.
            precession: Precession [rev/s], positive = forward, shape (m,).
            ratio: Precession over rotation, shape (m,).
            confidence: Confidence, 0 to 1, shape (m,).

        Raises:
            MessageError: A value is infinite.
        """
        for column, values in enumerate((orbit_radius, precession, ratio, confidence)):
            self._values[:, column] = values
        check_not_infinite(WHIRL_STATE, self._values)
        return self._template.fill(stamp, self._values.ravel())

    def rows(self, stamps: Sequence[int], values: Array) -> list[bytes]:
        """As `encode`, at each stamp [ns]: the four arrays as columns, shape (n, m, 4)."""
        check_not_infinite(WHIRL_STATE, values)
        return self._template.rows(stamps, values)


def read_whirl_state(state: JointState) -> WhirlOfMarks:
    """Findings of a `/whirl/state`.

    Raises:
        MessageError: The names are not those of a `/whirl/state`.
    """
    marks = tuple(name.removesuffix("/orbit_radius") for name in state.names if name.endswith("/orbit_radius"))
    if state.names != tuple(f"{mark}/{scalar}" for mark in marks for scalar in WHIRL_SCALARS):
        raise MessageError(
            f"expected the joints <mark>/{', <mark>/'.join(WHIRL_SCALARS)} of a /whirl/state, "
            f"found {', '.join(state.names) or 'none'}"
        )
    values = state.position.reshape(len(marks), len(WHIRL_SCALARS))
    return WhirlOfMarks(state.stamp, marks, *values.T)


def encode_motion(stamp: int, motions: Sequence[SubjectMotion], frame_id: str = FRAME_ID) -> bytes:
    """CDR of `/whirl/motion` at a stamp [ns]."""
    return encode_diagnostics(
        stamp,
        [
            Status(
                name=_MOTION + motion.subject,
                level=Level.OK,
                text=motion.state,
                values={"criterion": motion.criterion},
                hardware_id=motion.subject,
            )
            for motion in motions
        ],
        frame_id,
    )


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
    """CDR of `/whirl/onset` at a stamp [ns]; None before the onset."""
    if onset is None:
        return encode_diagnostics(stamp, [Status(_ONSET, Level.OK, _NONE_YET)], frame_id)
    text = f"whirl began at {onset.time:.2f} s at {onset.mark}, confidence {onset.confidence:.2f}"
    values = {"time": exact(onset.time), "mark": onset.mark, "confidence": exact(onset.confidence)}
    if onset.uncertainty is not None:
        values["uncertainty"] = exact(onset.uncertainty)
    if not onset.dated:
        text, values["dated"] = f"{text}; its time is not known within a revolution", "false"
    return encode_diagnostics(stamp, [Status(_ONSET, Level.WARN, text, values, onset.mark)], frame_id)


def decode_onset(raw: bytes) -> tuple[int, OnsetMessage | None]:
    """Stamp [ns] and onset of a `/whirl/onset`; None before the onset.

    Raises:
        MessageError: Not a `/whirl/onset`.
    """
    stamp, statuses = decode_diagnostics(raw)
    found = [status for status in statuses if status.name == _ONSET]
    if not found:
        raise MessageError(f"expected a status {_ONSET!r}, found {[status.name for status in statuses]}")
    values = found[0].values
    if not values:
        return stamp, None
    try:
        uncertainty = float(values["uncertainty"]) if "uncertainty" in values else None
        dated = values.get("dated") != "false"
        return stamp, OnsetMessage(
            float(values["time"]), values["mark"], float(values["confidence"]), uncertainty, dated
        )
    except (KeyError, ValueError) as error:
        raise MessageError(f"expected time, mark and confidence of the onset, found {dict(values)}") from error
