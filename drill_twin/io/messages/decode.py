# SPDX-License-Identifier: Apache-2.0
"""Decoding of messages into arrays: by offset where the layout is known, else by rosbags."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from drill_twin.core.arrays import Array, Mask
from drill_twin.core.errors import MessageError
from drill_twin.core.rig_channels import ARRAYS
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.stamps import NANOSECONDS, header_stamp
from drill_twin.io.messages.topic_row import CLOCK, FLOAT64, JOINT_STATE, POSE_ARRAY, STRING
from drill_twin.io.messages.type_store import CDR_LITTLE_ENDIAN, SPARE_BYTES, deserialize

_COUNT = struct.Struct("<I")
_STAMP = 4  # the header's stamp follows the four bytes of the encapsulation
_FRAME_ID = 12  # then the length of the frame's name


@dataclass(frozen=True, eq=False)
class JointArrays:
    """Arrays of one JointState, shape (k,), or of n of one layout, shape (n, k); each has k names, or is empty."""

    names: tuple[str, ...]
    """Joint names."""
    position: Array
    velocity: Array
    effort: Array
    frame_id: str
    """Frame of the header."""

    def index(self, name: str) -> int:
        """Index of a joint among the names.

        Raises:
            MessageError: There is no such joint.
        """
        if name not in self.names:
            raise MessageError(f"expected a joint {name!r}, found {', '.join(self.names) or 'none'}")
        return self.names.index(name)

    def column(self, array: str, name: str) -> Array:
        """Values of a joint in an array, one a message; NaN where the joint or the array is missing."""
        values: Array = getattr(self, array)
        if name in self.names and values.size:
            return values[..., self.names.index(name)]
        return np.full(values.shape[:-1], np.nan)

    @property
    def has_number(self) -> bool:
        """True if at least one value is finite."""
        return any(bool(np.isfinite(values).any()) for values in (self.velocity, self.effort, self.position))


@dataclass(frozen=True, eq=False)
class JointState(JointArrays):
    """One JointState."""

    stamp: int
    """Header stamp [ns]."""


@dataclass(frozen=True, eq=False)
class JointStates(JointArrays):
    """JointStates of one layout, one a row."""

    stamps: list[int]
    """Header stamps [ns]."""

    @classmethod
    def of(cls, state: JointState) -> JointStates:
        """Block of one message."""
        arrays = (state.position[None], state.velocity[None], state.effort[None])
        return cls(state.names, *arrays, state.frame_id, [state.stamp])

    @property
    def state(self) -> JointState:
        """The first message."""
        arrays = (self.position[0], self.velocity[0], self.effort[0])
        return JointState(self.names, *arrays, self.frame_id, self.stamps[0])


_Block = tuple[str, int, tuple[int, ...]]
"""Name, offset [bytes] and shape of a block of numbers in a message."""


@lru_cache(maxsize=64)
def _kind_of(length: int, blocks: tuple[_Block, ...]) -> tuple[np.dtype[np.void], Mask]:
    """Type of messages of a length [bytes] that begin with a header, and which bytes are no numbers; kept: 0.1 ms."""
    names, offsets, shapes = zip(*blocks, strict=True)
    kinds = ["<i4", "<u4", *(("<f8", shape) for shape in shapes)]
    names, offsets = ("seconds", "parts", *names), (_STAMP, _STAMP + 4, *offsets)
    kind = np.dtype({"names": names, "formats": kinds, "offsets": offsets, "itemsize": length})
    mask = np.full(length, True)
    for part, offset, *_ in (kind.fields or {}).values():
        mask[offset : offset + part.itemsize] = False
    return kind, mask


class _Layout:
    """Layout of messages of equal length: its numbers by offset, and what stands outside the numbers."""

    def __init__(self, example: bytes, *blocks: _Block) -> None:
        """Keep the layout of a message with these blocks of numbers."""
        self._example = np.frombuffer(example, np.uint8)
        self._kind, self._mask = _kind_of(len(example), blocks)

    def read(self, raws: Sequence[bytes]) -> tuple[list[int], NDArray[np.void]] | None:
        """Header stamps [ns] and blocks of messages, one a row; None where one differs outside its numbers."""
        if any(len(raw) != self._mask.size for raw in raws):
            return None
        joined = b"".join(raws)
        if ((np.frombuffer(joined, np.uint8).reshape(len(raws), -1) != self._example) & self._mask).any():
            return None
        rows = np.frombuffer(joined, self._kind)
        stamps: list[int] = (rows["seconds"].astype(np.int64) * NANOSECONDS + rows["parts"]).tolist()
        return stamps, rows


class JointStateReader:
    """Decoder of the JointStates of one publisher, 13 us for each message after the first.

    The first message is decoded by rosbags. If a template of its names gives the same bytes, its layout is kept, and
    later messages of equal length with equal bytes outside the numbers are read by offset. Any other message is
    decoded by rosbags again.
    """

    def __init__(self) -> None:
        self._layout: _Layout | None = None
        self._like: JointState | None = None  # a message of the layout
        self._refused: tuple[object, ...] = ()  # last layout whose template gives other bytes

    def read(self, raw: bytes) -> JointState:
        """Decode one message.

        Raises:
            MessageError: Not a JointState.
        """
        return self.read_one(raw).state

    def read_one(self, raw: bytes) -> JointStates:
        """Decode one message as a block of one; raises MessageError as `read`."""
        return self._by_layout([raw]) or JointStates.of(self._by_rosbags(raw))

    def read_rows(self, raws: Sequence[bytes]) -> JointStates | None:
        """Decode messages at once; None where their layouts differ, or their writer pads with other bytes.

        Raises:
            MessageError: The first message is not a JointState.
        """
        return self._by_layout(raws) or (self.read_one(raws[0]) and self._by_layout(raws))

    def _by_layout(self, raws: Sequence[bytes]) -> JointStates | None:
        """Decode messages of the layout that is kept; None where there is none, or a message has another."""
        found = None if self._layout is None else self._layout.read(raws)
        if found is None or self._like is None:
            return None
        stamps, rows = found
        position, velocity, effort = (rows[name].copy() for name in ARRAYS)
        return JointStates(self._like.names, position, velocity, effort, self._like.frame_id, stamps)

    def _by_rosbags(self, raw: bytes) -> JointState:
        """Decode a message, and keep its layout if a template of the layout gives exactly these bytes."""
        state = read_joint_state(raw)
        arrays = [getattr(state, name) for name in ARRAYS]
        sizes = [values.size for values in arrays]
        layout = (state.names, state.frame_id, *sizes)
        if layout == self._refused or not state.position.size:
            return state
        template = JointStateTemplate(
            state.names, velocity=bool(sizes[1]), effort=bool(sizes[2]), frame_id=state.frame_id
        )
        if template.fill(state.stamp, *arrays) != raw:
            self._refused = layout
            return state
        places = zip(ARRAYS, template.places, strict=True)
        self._layout, self._like = _Layout(raw, *((name, at, (size,)) for name, (size, at) in places)), state
        return state


def read_joint_state(raw: bytes) -> JointState:
    """Decode a JointState of any writer, by rosbags.

    Raises:
        MessageError: Not a JointState.
    """
    content = deserialize(raw, JOINT_STATE)
    names = tuple(content.name)
    arrays = [np.array(getattr(content, name), np.float64) for name in ARRAYS]
    for label, values in zip(ARRAYS, arrays, strict=True):
        if values.size not in {0, len(names)}:
            raise MessageError(
                f"expected a JointState with no or {len(names)} values of {label}, one a name, found {values.size}"
            )
    position, velocity, effort = arrays
    return JointState(names, position, velocity, effort, content.header.frame_id, header_stamp(content))


@dataclass(frozen=True, eq=False)
class PoseArray:
    """PoseArray as arrays."""

    stamp: int
    """Header stamp [ns]."""
    position: Array
    """Positions [m], shape (n, 3)."""
    orientation: Array
    """Unit quaternions x y z w, shape (n, 4)."""


def read_pose_array(raw: bytes) -> PoseArray:
    """Decode a PoseArray of any writer.

    Raises:
        MessageError: Not a PoseArray.
    """
    (stamp,), poses = read_pose_rows([raw]) or poses_by_rosbags(raw)
    return PoseArray(stamp, poses[0, :, :3], poses[0, :, 3:])


def read_pose_rows(raws: Sequence[bytes]) -> tuple[list[int], Array] | None:
    """Header stamps [ns] and poses x y z and quaternion x y z w, shape (n, nodes, 7), of messages of one layout.

    None where their layouts differ, or the first is not little-endian.

    Raises:
        MessageError: The first message is not a PoseArray.
    """
    first = raws[0]
    if first[:_STAMP] != CDR_LITTLE_ENDIAN:
        return None
    try:
        place = _FRAME_ID + 4 + _COUNT.unpack_from(first, _FRAME_ID)[0]
        place += -place % 4
        count = _COUNT.unpack_from(first, place)[0]
        place += 4
        place += (_STAMP - place) % 8 if count else 0
        if len(first) - place - 56 * count > SPARE_BYTES:
            raise ValueError("bytes left over")
        found = _Layout(first, ("poses", place, (count, 7))).read(raws)
    except (struct.error, ValueError) as error:
        raise MessageError(f"expected the CDR bytes of a {POSE_ARRAY}, found {len(first)} others ({error})") from error
    return None if found is None else (found[0], found[1]["poses"].copy())


def poses_by_rosbags(raw: bytes) -> tuple[list[int], Array]:
    """As `read_pose_rows` for one message of any writer."""
    content = deserialize(raw, POSE_ARRAY)
    poses = [(pose.position, pose.orientation) for pose in content.poses]
    rows = [(at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w) for at, turn in poses]
    return [header_stamp(content)], np.array(rows).reshape(1, -1, 7)


def read_float64(raw: bytes) -> float:
    """Decode a std_msgs/Float64.

    Raises:
        MessageError: Not a Float64.
    """
    return float(deserialize(raw, FLOAT64).data)


def read_string(raw: bytes) -> str:
    """Decode a std_msgs/String.

    Raises:
        MessageError: Not a String.
    """
    return str(deserialize(raw, STRING).data)


def read_clock(raw: bytes) -> int:
    """Decode a rosgraph_msgs/Clock to a stamp [ns].

    Raises:
        MessageError: Not a Clock.
    """
    clock = deserialize(raw, CLOCK).clock
    return int(clock.sec) * 1_000_000_000 + int(clock.nanosec)
