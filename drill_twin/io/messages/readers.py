# SPDX-License-Identifier: Apache-2.0
"""Decoder of each topic of the contract, by its row."""

from collections.abc import Callable
from functools import partial
from typing import Any

from drill_twin.io.messages.decode import JointStateReader, read_clock, read_float64, read_pose_array, read_string
from drill_twin.io.messages.diagnostics import decode_diagnostics
from drill_twin.io.messages.sensor_messages import read_imu
from drill_twin.io.messages.topic_row import CLOCK, DIAGNOSTIC_ARRAY, FLOAT64, IMU, JOINT_STATE, POSE_ARRAY, STRING
from drill_twin.io.messages.topics import TOPICS, WHIRL_MOTION, WHIRL_ONSET
from drill_twin.io.messages.type_store import deserialize
from drill_twin.io.messages.whirl_encode import decode_motion, decode_onset

Reader = Callable[[bytes], Any]
"""Decodes a message, or raises MessageError."""
_OF_TYPES: dict[str, Reader] = {
    CLOCK: read_clock,
    DIAGNOSTIC_ARRAY: decode_diagnostics,
    FLOAT64: read_float64,
    IMU: read_imu,
    POSE_ARRAY: read_pose_array,
    STRING: read_string,
}
_OF_TOPICS: dict[str, Reader] = {WHIRL_MOTION: decode_motion, WHIRL_ONSET: decode_onset}


def reader_of(topic: str) -> Reader:
    """Decoder of the messages of one publisher of a topic: JointStates have a layout that it keeps."""
    kind = TOPICS[topic].type_name
    if kind == JOINT_STATE:
        return JointStateReader().read
    return _OF_TOPICS.get(topic) or _OF_TYPES.get(kind) or partial(deserialize, type_name=kind)
