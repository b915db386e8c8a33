# SPDX-License-Identifier: Apache-2.0
"""Messages on `/twin/summary`: what a dashboard wants, five times a simulated second, as numbers without NaN."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.finite import finite_number
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.io.messages.topics import FRAME_ID, TWIN_SUMMARY
from drill_twin.whirl import BitMotion, MarkInfo, MotionCode, MotionState, Onset, StickSlipCode

PERIOD = NANOSECONDS // 5
"""Simulated time between two messages [ns]."""
_RIG = ("rate_of_penetration", "weight_on_bit", "rotation")
_FINDINGS = ("whirl", "whirl_severity", "stick_slip", "stick_slip_severity", "onset", "realtime_factor")


class RigSample(NamedTuple):
    """Values of a `/rig/state` that the analysis takes, NaN for those that it does not have."""

    top_speed: float
    """Speed of the top drive [rad/s]."""
    bit_speed: float
    """Speed of the bit [rad/s]."""
    weight: float = math.nan
    """Weight on bit [N]."""
    drilled: float = math.nan
    """Depth drilled [m]."""


UNKNOWN_RIG = RigSample(math.nan, math.nan)
"""No `/rig/state`."""


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

    A value of the rig that the first sample does not have is left out of all messages; one that later ones lack stays.
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
            MessageError: It is not finite.
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
