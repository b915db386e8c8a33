# SPDX-License-Identifier: Apache-2.0
"""Read the topics of a bag into arrays over time, by header stamps."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.errors import BagError, MessageError
from drill_twin.io.bag.arrays import (
    CommandSeries,
    JointSeries,
    MarkSeries,
    PoseSeries,
    RigSeries,
    WhirlSeries,
)
from drill_twin.io.bag.reader import Bag
from drill_twin.io.messages.decode import JointState, JointStateReader, read_pose_array
from drill_twin.io.messages.diagnostics import Status, decode_diagnostics
from drill_twin.io.messages.encode import MARK_AXES, RIG_JOINTS, read_command
from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.io.messages.topics import (
    DIAGNOSTICS,
    MARKS_STATE,
    RIG_COMMAND,
    RIG_STATE,
    STRING_POSES,
    WHIRL_MOTION,
    WHIRL_ONSET,
    WHIRL_STATE,
)
from drill_twin.io.messages.whirl_encode import (
    WHIRL_SCALARS,
    Motion,
    OnsetMessage,
    decode_motion,
    decode_onset,
    read_whirl_state,
)

T = TypeVar("T")


def joint_series(bag: Bag, topic: str) -> JointSeries:
    """All messages of a JointState topic.

    Raises:
        BagError: There is none, one cannot be decoded, or the joints change.
    """
    reader = JointStateReader()
    states = _decoded(bag, topic, reader.read)
    names = states[0].names
    for state in states:
        if state.names != names:
            raise BagError(
                f"{bag.path}: expected the joints {', '.join(names)} on {topic} throughout, "
                f"found {', '.join(state.names)} at {state.stamp / NANOSECONDS:.3f} s; "
                "the bag holds more than one scene"
            )
    return JointSeries(
        np.array([state.stamp for state in states], np.int64),
        names,
        _stacked(bag, topic, [state.position for state in states]),
        _stacked(bag, topic, [state.velocity for state in states]),
        _stacked(bag, topic, [state.effort for state in states]),
    )


def pose_series(bag: Bag) -> PoseSeries:
    """`/string/poses`.

    Raises:
        BagError: There is none, one cannot be decoded, or the number of nodes changes.
    """
    poses = _decoded(bag, STRING_POSES, read_pose_array)
    return PoseSeries(
        np.array([pose.stamp for pose in poses], np.int64),
        _stacked(bag, STRING_POSES, [pose.position for pose in poses]),
        _stacked(bag, STRING_POSES, [pose.orientation for pose in poses]),
    )


def mark_series(bag: Bag) -> MarkSeries:
    """`/marks/state`.

    Raises:
        BagError: There is none, one cannot be decoded, or the joints are not those of marks.
    """
    joints = joint_series(bag, MARKS_STATE)
    marks = tuple(name.removesuffix("/x") for name in joints.names if name.endswith("/x"))
    if joints.names != tuple(f"{mark}/{axis}" for mark in marks for axis in MARK_AXES):
        raise _other_joints(bag, MARKS_STATE, f"<mark>/{', <mark>/'.join(MARK_AXES)}", joints.names)
    shape = (joints.stamp.size, len(marks), len(MARK_AXES))
    position, velocity, effort = (
        _filled(bag, MARKS_STATE, values, joints).reshape(shape)
        for values in (joints.position, joints.velocity, joints.effort)
    )
    return MarkSeries(
        joints.stamp,
        marks,
        position[..., :3],
        position[..., 3],
        velocity[..., :3],
        velocity[..., 3],
        np.hypot(effort[..., 0], effort[..., 1]),
    )


def rig_series(bag: Bag) -> RigSeries:
    """`/rig/state`.

    Raises:
        BagError: There is none, one cannot be decoded, or a joint is missing.
    """
    joints = joint_series(bag, RIG_STATE)
    if joints.names != RIG_JOINTS:
        raise _other_joints(bag, RIG_STATE, ", ".join(RIG_JOINTS), joints.names)
    position, velocity, effort = (
        _filled(bag, RIG_STATE, values, joints).T for values in (joints.position, joints.velocity, joints.effort)
    )
    return RigSeries(
        joints.stamp,
        top_drive_angle=position[0],
        top_drive_speed=velocity[0],
        top_drive_torque=effort[0],
        bit_angle=position[1],
        bit_speed=velocity[1],
        bit_torque=effort[3],
        bit_force=effort[1],
        block_position=position[2],
        block_velocity=velocity[2],
        hookload=effort[2],
    )


def command_series(bag: Bag) -> CommandSeries:
    """`/rig/command`.

    Raises:
        BagError: There is none, one cannot be decoded, or a set-point is missing.
    """
    reader = JointStateReader()

    def both(raw: bytes) -> tuple[int, float, float]:
        state = reader.read(raw)
        command = read_command(state)
        return state.stamp, command.weight_on_bit, command.rotation

    rows = _decoded(bag, RIG_COMMAND, both)
    stamps, forces, speeds = zip(*rows, strict=True)
    return CommandSeries(np.array(stamps, np.int64), np.array(forces, np.float64), np.array(speeds, np.float64))


def whirl_series(bag: Bag) -> WhirlSeries:
    """`/whirl/state`, the findings of the analyzer that ran live.

    Raises:
        BagError: There is none, one cannot be decoded, or the joints are not those of findings.
    """
    joints = joint_series(bag, WHIRL_STATE)
    first = JointState(int(joints.stamp[0]), joints.names, joints.position[0], joints.velocity[0], joints.effort[0])
    try:
        marks = read_whirl_state(first).marks
    except MessageError as error:
        raise BagError(f"{bag.path}: {WHIRL_STATE}: {error}") from error
    values = joints.position.reshape(joints.stamp.size, len(marks), len(WHIRL_SCALARS))
    return WhirlSeries(joints.stamp, marks, *np.moveaxis(values, 2, 0))


def motions(bag: Bag) -> list[tuple[int, list[Motion]]]:
    """All messages on `/whirl/motion`: header stamp [ns] and motion states; empty where there are none."""
    return _decoded(bag, WHIRL_MOTION, decode_motion, needed=False)


def onset(bag: Bag) -> OnsetMessage | None:
    """The onset that the live analyzer announced last on `/whirl/onset`, if any."""
    announced = _decoded(bag, WHIRL_ONSET, decode_onset, needed=False)
    return announced[-1][1] if announced else None


def diagnostics(bag: Bag) -> list[tuple[int, list[Status]]]:
    """All messages on `/diagnostics`: header stamp [ns] and statuses; empty where there are none."""
    return _decoded(bag, DIAGNOSTICS, decode_diagnostics, needed=False)


def _decoded(bag: Bag, topic: str, decode: Callable[[bytes], T], *, needed: bool = True) -> list[T]:
    values = []
    for _, stamp, raw in bag.messages((topic,)):
        try:
            values.append(decode(raw))
        except MessageError as error:
            raise BagError(f"{bag.path}: {topic} recorded at {stamp} ns: {error}") from error
    if needed and not values:
        raise BagError(
            f"{bag.path}: expected messages on {topic}, found none; the bag holds "
            f"{', '.join(name for name, recorded in bag.topics.items() if recorded.count)}"
        )
    return values


def _stacked(bag: Bag, topic: str, rows: list[Array]) -> Array:
    try:
        return np.stack(rows)
    except ValueError as error:
        raise BagError(
            f"{bag.path}: expected messages of one size on {topic}, found several; the bag holds more than one scene"
        ) from error


def _filled(bag: Bag, topic: str, values: Array, joints: JointSeries) -> Array:
    if values.shape[1] != len(joints.names):
        raise BagError(
            f"{bag.path}: expected position, velocity and effort of each joint on {topic}, found one of them empty"
        )
    return values


def _other_joints(bag: Bag, topic: str, expected: str, found: tuple[str, ...]) -> BagError:
    return BagError(f"{bag.path}: expected the joints {expected} on {topic}, found {', '.join(found) or 'none'}")
