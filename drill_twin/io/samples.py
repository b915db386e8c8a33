# SPDX-License-Identifier: Apache-2.0
"""Samples for the whirl analysis, from the messages on `/marks/state` and `/rig/state`, and their order."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array
from drill_twin.core.errors import MessageError
from drill_twin.dynamics.twin.frame import Frames, RigState
from drill_twin.io.messages.decode import JointState, JointStates
from drill_twin.io.messages.encode import MARK_AXES, wall_push
from drill_twin.io.messages.rig_messages import BIT_AXIAL
from drill_twin.io.messages.topics import MARKS_STATE, RIG_STATE

WAITING = 256
"""Largest number of samples of one topic that wait for their partner of the other, or for the scene."""

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


UNKNOWN_RIG = RigSample(math.nan, math.nan)
"""No `/rig/state`."""


class Sample(NamedTuple):
    """State of the marks with the state of the rig at the same stamp [ns]."""

    stamp: int
    marks: JointState
    rig: RigSample = UNKNOWN_RIG


class SampleRows(NamedTuple):
    """States of m marks and of the rig at the same stamps, one a row."""

    position: Array
    """Marked points [m], shape (n, m, 3)."""
    spin: Array
    """Spin at the marks [rad], shape (n, m)."""
    wall_force: Array | None
    """Normal wall force at the marks [N], shape (n, m); None without forces."""
    top_speed: Array
    """Speed of the top drive [rad/s], shape (n,)."""
    bit_speed: Array
    """Speed of the bit [rad/s], shape (n,)."""
    weight: Array | None = None
    """Weight on bit [N], shape (n,); None where no `/twin/summary` is wanted, as for `drilled`."""
    drilled: Array | None = None
    """Depth drilled [m], shape (n,)."""

    @property
    def rigs(self) -> list[RigSample] | None:
        """State of the rig at each stamp, for `/twin/summary`."""
        if self.weight is None or self.drilled is None:
            return None
        columns = np.column_stack((self.top_speed, self.bit_speed, self.weight, self.drilled))
        return [RigSample(*row) for row in columns.tolist()]

    @classmethod
    def of(cls, frames: Frames) -> SampleRows:
        """Samples of frames from `/marks/state` and `/rig/state`; the force is the size of its two components."""
        push = wall_push(frames.marks.centre, frames.marks.wall_force)
        names = ("top_drive_speed", "bit_speed", "bit_force", "drilled")
        rig = (frames.rig[:, RigState._fields.index(name)] for name in names)
        return cls(frames.marks.position, frames.marks.spin, np.hypot(push[..., 0], push[..., 1]), *rig)


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
        return bool(self._marks or self._rigs)

    def clear(self) -> None:
        """Discard the states that wait for a partner."""
        self._marks: dict[int, JointState] = {}
        self._rigs: dict[int, RigSample] = {}

    def add_marks(self, state: JointState) -> Sample | None:
        """Add a state of the marks; return the sample if its partner is there."""
        self._marks[state.stamp] = state
        return self._pair(state.stamp, self._marks)

    def add_rig(self, stamp: int, rig: RigSample) -> Sample | None:
        """Add the state of the rig at a stamp [ns]; return the sample if its partner is there."""
        self._rigs[stamp] = rig
        return self._pair(stamp, self._rigs)

    def _pair(self, stamp: int, waiting: dict[int, JointState] | dict[int, RigSample]) -> Sample | None:
        if stamp in self._marks and stamp in self._rigs:
            return Sample(stamp, self._marks.pop(stamp), self._rigs.pop(stamp))
        while len(waiting) > WAITING:
            waiting.pop(next(iter(waiting)))
            self.unpaired += 1
        return None


class MarkReader:
    """Reads positions, spin and wall force of given marks; the columns are kept while the layout is the same."""

    def __init__(self, marks: Sequence[str]) -> None:
        self._marks = marks
        self._layout: tuple[str, ...] = ()
        self._columns = np.zeros((0, len(MARK_AXES)), np.intp)

    def read(self, state: JointState | JointStates) -> tuple[Array, Array, Array | None]:
        """Read one state, or states one a row, whose arrays have one dimension more.

        Returns:
            Positions [m], shape (m, 3), spin [rad], shape (m,), and wall force [N], shape (m,), or None without forces.

        Raises:
            MessageError: The message has no positions, or positions of other marks.
        """
        self.check(state)
        values, force = self._chosen(state.position), None
        if state.effort.size:
            components = self._chosen(state.effort)
            force = np.hypot(components[..., 0], components[..., 1])
        return values[..., :3], values[..., 3], force

    def _chosen(self, values: Array) -> Array:
        """Values of the marks by axis, shape (..., m, 4); NaN for an axis that the message lacks."""
        unknown = np.full((*values.shape[:-1], 1), np.nan)
        return np.concatenate((values, unknown), axis=-1)[..., self._columns]

    def check(self, state: JointState | JointStates) -> None:
        """Check that the marks are in a message.

        Raises:
            MessageError: As `read`.
        """
        if state.names != self._layout:
            self._columns = columns(state.names, self._marks)
            self._layout = state.names
        if not state.position.size:
            raise MessageError(f"expected positions on {MARKS_STATE}, found none")


def rig_of(state: JointState) -> RigSample:
    """Values of a `/rig/state`: the speed of the top drive, and the others if they are there.

    Raises:
        MessageError: There is no top drive, it has no speed, or a speed is infinite or beyond all reason.
    """
    drive = state.index("top_drive")
    if drive >= state.velocity.size:
        raise MessageError(f"expected the speed of top_drive on {RIG_STATE}, found no velocities")
    bit = state.names.index("bit") if "bit" in state.names else state.velocity.size
    found = float(state.velocity[drive]), float(state.velocity[bit]) if bit < state.velocity.size else math.nan
    if any(abs(speed) > FASTEST for speed in found):
        raise MessageError(f"expected speeds within {FASTEST:g} rad/s on {RIG_STATE}, found {found[0]:g}, {found[1]:g}")
    axial = state.names.index(BIT_AXIAL) if BIT_AXIAL in state.names else len(state.names)
    weight, drilled = (
        float(values[axial]) if axial < values.size else math.nan for values in (state.effort, state.position)
    )
    return RigSample(*found, weight, drilled)


def columns(names: Sequence[str], marks: Sequence[str]) -> NDArray[np.intp]:
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


class _Stamped(Protocol):
    @property
    def stamp(self) -> int: ...


Item = TypeVar("Item", bound=_Stamped)


class SampleOrder(Generic[Item]):
    """Finds `STUCK` ordered samples that are all before the latest stamp.

    Single late samples are rejected by the analyzer; but after one stamp from the future, or a clock set back, all
    samples would be rejected.

    Attributes:
        latest: Latest stamp so far [ns]; -1 before the first.
    """

    def __init__(self) -> None:
        self.latest = -1
        self._behind: list[Item] = []

    def note(self, sample: Item) -> list[Item]:
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
