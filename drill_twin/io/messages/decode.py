# SPDX-License-Identifier: Apache-2.0
"""Decoding of messages into arrays: by offset where the layout is known, else by rosbags."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array, Bytes
from drill_twin.core.errors import MessageError
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.stamps import NANOSECONDS, header_stamp, unpack_stamp
from drill_twin.io.messages.topic_row import CLOCK, FLOAT64, JOINT_STATE, POSE_ARRAY, STRING
from drill_twin.io.messages.topics import FRAME_ID
from drill_twin.io.messages.type_store import CDR_LITTLE_ENDIAN, SPARE_BYTES, deserialize

_COUNT = struct.Struct("<I")
_STAMP = 4  # the header's stamp follows the four bytes of the encapsulation
_FRAME_ID = 12  # then the length of the frame's name


@dataclass(frozen=True, eq=False)
class JointState:
    """JointState as arrays; each is empty or as long as the names."""

    stamp: int
    """Header stamp [ns]."""
    names: tuple[str, ...]
    """Joint names."""
    position: Array
    velocity: Array
    effort: Array
    frame_id: str = FRAME_ID
    """Frame of the header."""

    def index(self, name: str) -> int:
        """Index of a joint among the names.

        Raises:
            MessageError: There is no such joint.
        """
        try:
            return self.names.index(name)
        except ValueError:
            raise MessageError(f"expected a joint {name!r}, found {', '.join(self.names) or 'none'}") from None

    @property
    def has_number(self) -> bool:
        """True if at least one value is finite."""
        return any(bool(np.isfinite(values).any()) for values in (self.velocity, self.effort, self.position))


@dataclass(frozen=True, eq=False)
class JointStates:
    """JointStates of one layout, one a row; each array has a column for each name, or none."""

    stamps: list[int]
    """Header stamps [ns]."""
    names: tuple[str, ...]
    """Joint names."""
    position: Array
    velocity: Array
    effort: Array
    frame_id: str


class JointStateReader:
    """Decoder of the JointStates of one publisher: 5 us each after the first.

    The first message is decoded by rosbags. If a template of its names gives the same bytes, its layout is kept, and a
    later message of equal length with equal bytes outside the numbers is read by offset. Any other message is decoded
    by rosbags again.
    """

    def __init__(self) -> None:
        self._length = -1
        self._names: tuple[str, ...] = ()
        self._frame_id = FRAME_ID
        self._text = slice(0, 0)  # frame, names and the position's length
        self._text_bytes = b""
        self._gaps: list[tuple[slice, bytes]] = []
        self._places = [(0, 0)] * 3
        self._refused: tuple[object, ...] = ()  # last layout whose template gives other bytes

    def read(self, raw: bytes) -> JointState:
        """Decode one message.

        Raises:
            MessageError: Not a JointState.
        """
        if len(raw) == self._length and raw[self._text] == self._text_bytes and self._gaps_agree(raw):
            arrays = [np.frombuffer(raw, np.float64, count, offset).copy() for count, offset in self._places]
            return JointState(unpack_stamp(raw), self._names, arrays[0], arrays[1], arrays[2], self._frame_id)
        state = read_joint_state(raw)
        self._keep_layout(raw, state)
        return state

    def read_rows(self, raws: Sequence[bytes]) -> JointStates | None:
        """Decode messages at once; None where no layout is kept, or a message has another layout."""
        if self._length < 0 or any(len(raw) != self._length for raw in raws):
            return None
        table = np.frombuffer(b"".join(raws), np.uint8).reshape(len(raws), self._length)
        for part, expected in ((slice(_STAMP), CDR_LITTLE_ENDIAN), (self._text, self._text_bytes), *self._gaps):
            if (table[:, part] != np.frombuffer(expected, np.uint8)).any():
                return None
        position, velocity, effort = (float_columns(table, offset, count) for count, offset in self._places)
        return JointStates(header_stamps(table), self._names, position, velocity, effort, self._frame_id)

    def _gaps_agree(self, raw: bytes) -> bool:
        return raw[:_STAMP] == CDR_LITTLE_ENDIAN and all(raw[gap] == expected for gap, expected in self._gaps)

    def _keep_layout(self, raw: bytes, state: JointState) -> None:
        """Keep the layout if its template gives exactly these bytes."""
        layout = (state.names, state.frame_id, state.position.size, state.velocity.size, state.effort.size)
        if layout == self._refused or not state.position.size:
            return
        template = JointStateTemplate(
            state.names, velocity=bool(state.velocity.size), effort=bool(state.effort.size), frame_id=state.frame_id
        )
        if template.fill(state.stamp, state.position, state.velocity, state.effort) != raw:
            self._refused = layout
            return
        self._places = [(size, offset) for size, offset in template.places]
        self._names, self._frame_id = state.names, state.frame_id
        self._length = len(raw)
        start, end = _FRAME_ID, self._places[0][1]
        self._text, self._text_bytes = slice(start, end), raw[start:end]
        self._gaps = [(gap, raw[gap]) for gap in _gaps_after(self._places, len(raw))]


def header_stamps(table: Bytes) -> list[int]:
    """Header stamps [ns] of messages in little-endian CDR, one a row, shape (n, bytes)."""
    whole = np.ascontiguousarray(table[:, _STAMP : _STAMP + 4]).view("<i4").astype(np.int64)
    part = np.ascontiguousarray(table[:, _STAMP + 4 : _STAMP + 8]).view("<u4").astype(np.int64)
    stamps: list[int] = (whole * NANOSECONDS + part).ravel().tolist()
    return stamps


def float_columns(table: Bytes, offset: int, count: int) -> Array:
    """Numbers from an offset on in messages, one a row; shape (n, count)."""
    numbers: Array = np.ascontiguousarray(table[:, offset : offset + 8 * count]).view(np.float64)
    return numbers.reshape(len(table), count)


def _gaps_after(places: list[tuple[int, int]], length: int) -> list[slice]:
    """Slices after the first block that hold no numbers: lengths and padding."""
    gaps, end = [], places[0][1] + 8 * places[0][0]
    for count, offset in places[1:]:
        if count:
            gaps.append(slice(end, offset))
            end = offset + 8 * count
    gaps.append(slice(end, length))
    return gaps


def read_joint_state(raw: bytes) -> JointState:
    """Decode a JointState of any writer, by rosbags.

    Raises:
        MessageError: Not a JointState.
    """
    content = deserialize(raw, JOINT_STATE)
    names = tuple(content.name)
    arrays = [np.array(values, np.float64) for values in (content.position, content.velocity, content.effort)]
    for label, values in zip(("position", "velocity", "effort"), arrays, strict=True):
        if values.size not in {0, len(names)}:
            raise MessageError(
                f"expected a JointState with no or {len(names)} values of {label}, one a name, found {values.size}"
            )
    return JointState(header_stamp(content), names, arrays[0], arrays[1], arrays[2], content.header.frame_id)


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
    """Decode a PoseArray of any writer; 3 us where it is little-endian.

    Raises:
        MessageError: Not a PoseArray.
    """
    if raw[:_STAMP] != CDR_LITTLE_ENDIAN:
        return _poses_by_rosbags(raw)
    try:
        place, count = _pose_block(raw)
        poses = np.frombuffer(raw, np.float64, 7 * count, place).reshape(count, 7).copy()
        if len(raw) - place - 56 * count > SPARE_BYTES:
            raise ValueError("bytes left over")
    except (struct.error, ValueError) as error:
        raise MessageError(f"expected the CDR bytes of a {POSE_ARRAY}, found {len(raw)} others ({error})") from error
    return PoseArray(unpack_stamp(raw), poses[:, :3], poses[:, 3:])


def _pose_block(raw: bytes) -> tuple[int, int]:
    """Offset of the numbers of a PoseArray, and number of poses."""
    place = _FRAME_ID + 4 + _COUNT.unpack_from(raw, _FRAME_ID)[0]
    place += -place % 4
    count = _COUNT.unpack_from(raw, place)[0]
    place += 4
    return place + ((_STAMP - place) % 8 if count else 0), count


def read_pose_rows(raws: Sequence[bytes]) -> tuple[list[int], Array] | None:
    """Header stamps [ns] and poses x y z and quaternion x y z w, shape (n, nodes, 7), of messages of one layout.

    None where their layouts differ, or a message is not little-endian.

    Raises:
        MessageError: The first message is not a PoseArray.
    """
    read_pose_array(raws[0])
    length = len(raws[0])
    if raws[0][:_STAMP] != CDR_LITTLE_ENDIAN or any(len(raw) != length for raw in raws):
        return None
    place, count = _pose_block(raws[0])
    table = np.frombuffer(b"".join(raws), np.uint8).reshape(len(raws), length)
    for part in (slice(_STAMP), slice(_FRAME_ID, place)):
        if (table[:, part] != table[:1, part]).any():
            return None
    return header_stamps(table), float_columns(table, place, 7 * count).reshape(len(raws), count, 7)


def _poses_by_rosbags(raw: bytes) -> PoseArray:
    content = deserialize(raw, POSE_ARRAY)
    position = [(at.x, at.y, at.z) for at in (pose.position for pose in content.poses)]
    orientation = [(turn.x, turn.y, turn.z, turn.w) for turn in (pose.orientation for pose in content.poses)]
    return PoseArray(header_stamp(content), np.array(position).reshape(-1, 3), np.array(orientation).reshape(-1, 4))


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
