# SPDX-License-Identifier: Apache-2.0
"""Samples for the whirl analysis, from the messages on `/marks/state` and `/rig/state`, and their order."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.core.errors import MessageError
from drill_twin.core.rig_channels import RIG_CHANNELS
from drill_twin.dynamics.twin.frame import Frames, RigState
from drill_twin.io.messages.decode import JointStates
from drill_twin.io.messages.encode import MARK_AXES, wall_push
from drill_twin.io.messages.sensor_messages import ImuReading
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE

WAITING = 256
"""Largest number of samples of one topic that wait for their partner of the other, or for the scene."""

RIG_FIELDS = [RigState._fields.index(name) for name in ("top_drive_speed", "bit_speed", "bit_force", "drilled")]
"""Fields of `RigSample` in `RigState`."""

FASTEST = 1e6
"""Largest speed of top drive and bit that is taken for one [rad/s]."""


class RigSample(NamedTuple):
    """Values of a `/rig/state` that the analysis takes, NaN for values that the message does not have."""

    top_speed: float
    """Speed of the top drive [rad/s]."""
    bit_speed: float
    """Speed of the bit [rad/s]."""
    weight: float = math.nan
    """Weight on bit [N]."""
    drilled: float = math.nan
    """Depth drilled [m]."""


UNKNOWN_RIG = np.full((1, len(RigSample._fields)), np.nan)
"""Fields of `RigSample` without a `/rig/state`."""


class Sample(NamedTuple):
    """State of the marks with the state of the rig at the same stamp [ns]: blocks of one."""

    stamp: int
    marks: JointStates
    rig: Array = UNKNOWN_RIG


AnySample = Sample | ImuReading
"""Input of the analysis at a stamp: marks and rig, or a reading of a sub."""


class SampleRows(NamedTuple):
    """States of m marks and of the rig at the same stamps, one a row."""

    stamps: list[int]
    """Stamps [ns]."""
    position: Array
    """Marked points [m], shape (n, m, 3)."""
    spin: Array
    """Spin at the marks [rad], shape (n, m)."""
    wall_force: Array | None
    """Normal wall force at the marks [N], shape (n, m); None without forces."""
    rig: Array
    """Fields of `RigSample`, shape (n, 4)."""
    frame_id: str
    """Frame of the marks."""

    @classmethod
    def of(cls, stamps: list[int], frames: Frames, frame_id: str) -> SampleRows:
        """Samples of frames from `/marks/state` and `/rig/state`; the force is the size of its two components."""
        push, marks = wall_push(frames.marks.centre, frames.marks.wall_force), frames.marks
        force = np.hypot(push[..., 0], push[..., 1])
        return cls(stamps, marks.position, marks.spin, force, frames.rig[:, RIG_FIELDS], frame_id)


class SamplePairing:
    """Pairs the states of marks and rig by stamp, in any order of arrival.

    Attributes:
        unpaired: Number of states that were discarded without a partner.
    """

    def __init__(self) -> None:
        self.unpaired = 0
        self.clear()

    @property
    def waits(self) -> bool:
        """True while a state waits for its partner."""
        return any(self._waiting.values())

    def clear(self) -> None:
        """Discard the states that wait for a partner."""
        self._waiting: dict[str, dict[int, Any]] = {MARKS_STATE: {}, RIG_STATE: {}}

    def add(self, topic: str, stamp: int, state: JointStates | Array) -> Sample | None:
        """Add a state of marks or rig at a stamp [ns]; return the sample if its partner is there."""
        waiting = self._waiting[topic]
        waiting[stamp] = state
        if all(stamp in states for states in self._waiting.values()):
            return Sample(stamp, *(states.pop(stamp) for states in self._waiting.values()))
        if len(waiting) > WAITING:
            waiting.pop(next(iter(waiting)))
            self.unpaired += 1
        return None


def read_marks(states: JointStates, marks: tuple[str, ...], rig: Array) -> SampleRows:
    """Positions, spin and wall force of given marks: samples of the states, one a row.

    Args:
        states: States of the marks.
        marks: Names of the marks that are read.
        rig: Fields of `RigSample` at the same stamps, shape (n, 4).

    Raises:
        MessageError: The messages have no positions, or positions of other marks.
    """
    chosen = marks_in(states, marks)
    values, force = _with_missing(states.position)[:, chosen], None
    if states.effort.size:
        components = _with_missing(states.effort)[:, chosen]
        force = np.hypot(components[..., 0], components[..., 1])
    return SampleRows(states.stamps, values[..., :3], values[..., 3], force, rig, states.frame_id)


def marks_in(states: JointStates, marks: tuple[str, ...]) -> NDArray[np.intp]:
    """Joints of marks in a message, as of `columns`; raises MessageError as `read_marks`."""
    found = columns(states.names, marks)
    if not states.position.size:
        raise MessageError(f"expected positions on {MARKS_STATE}, found none")
    return found


def _with_missing(values: Array) -> Array:
    """Values of the joints, and NaN for an axis that the messages lack, shape (n, j + 1)."""
    return np.concatenate((values, np.full((len(values), 1), np.nan)), axis=1)


def rig_of(states: JointStates) -> Array:
    """Fields of `RigSample` in `/rig/state`, shape (n, 4): the speed of the top drive, and the others if there.

    Raises:
        MessageError: There is no top drive, it has no speed, or a speed is infinite or beyond all reason.
    """
    if states.index("top_drive") >= states.velocity.shape[1]:
        raise MessageError(f"expected the speed of top_drive on {RIG_STATE}, found no velocities")
    channels = (RIG_CHANNELS[RigState._fields[field]] for field in RIG_FIELDS)
    found = np.stack([states.column(channel.array, channel.joint) for channel in channels], axis=1)
    if (fast := (np.abs(found[:, :2]) > FASTEST).any(axis=1)).any():
        top, bit = found[fast, :2][0]
        raise MessageError(f"expected speeds within {FASTEST:g} rad/s on {RIG_STATE}, found {top:g}, {bit:g}")
    return found


@lru_cache(maxsize=8)
def columns(names: tuple[str, ...], marks: tuple[str, ...]) -> NDArray[np.intp]:
    """Indices of x, y, z and spin of the marks among the joints of a `/marks/state`, shape (m, 4).

    A missing z or spin has the index after the last. Joints of other marks are ignored.

    Raises:
        MessageError: A mark has no x or no y.
    """
    places = {name: k for k, name in enumerate(names)}
    missing = [f"{mark}/{axis}" for mark in marks for axis in MARK_AXES[:2] if f"{mark}/{axis}" not in places]
    if missing:
        raise MessageError(
            f"expected the marks of the scene on {MARKS_STATE}, with {', '.join(missing)}, "
            f"found {', '.join(names) or 'none'}"
        )
    found = [[places.get(f"{mark}/{axis}", len(names)) for axis in MARK_AXES] for mark in marks]
    return np.array(found, np.intp)


STUCK = 200
"""Number of ordered samples, all before the latest stamp, after which the analysis starts again; 1 to 2 s."""


class SampleOrder:
    """Finds `STUCK` ordered samples that are all before the latest stamp.

    Single late samples are rejected by the analyzer; but after one stamp from the future, or a clock set back, all
    samples would be rejected.

    Attributes:
        latest: Latest stamp so far [ns]; -1 before the first.
    """

    def __init__(self) -> None:
        self.latest = -1
        self._behind: list[AnySample] = []

    def note(self, sample: AnySample) -> list[AnySample]:
        """Note a sample; return the samples with which the analysis is to start again, mostly none."""
        if sample.stamp >= self.latest:
            self.pass_by(sample.stamp)
            return []
        if self._behind and sample.stamp <= self._behind[-1].stamp:
            self._behind.clear()
        self._behind.append(sample)
        return list(self._behind) if len(self._behind) >= STUCK else []

    def pass_by(self, stamp: int) -> None:
        """Note ordered samples up to a stamp [ns], none of which is before the latest."""
        self.latest = stamp
        self._behind.clear()
