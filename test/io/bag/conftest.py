# SPDX-License-Identifier: Apache-2.0
"""Bags of made-up frames, and the messages in them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from one_frame import frames_of

from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages import topics
from drill_twin.io.messages.diagnostics import Level, Status, encode_diagnostics
from drill_twin.io.messages.encode import TwinEncoder, encode_string
from drill_twin.io.messages.rig_messages import CommandEncoder
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.messages.whirl_encode import (
    OnsetMessage,
    SubjectMotion,
    WhirlStateEncoder,
    encode_motion,
    encode_onset,
)
from drill_twin.scene.set_points.command import Command

SCENE = "name: made up\nrun:\n  seed: 1\n"
ONSET = OnsetMessage(time=0.3, mark="mark_3")
MOTION = SubjectMotion("mark_3", "forward whirl", "ratio 0.5 for 3 revolutions")

Message = tuple[str, int, bytes]


@pytest.fixture(scope="session")
def frames(make_frame):
    return [make_frame(nodes=11, time=0.01 * k, seed=k) for k in range(40)]


@pytest.fixture
def scene() -> str:
    return SCENE


@pytest.fixture
def onset() -> OnsetMessage:
    return ONSET


@pytest.fixture
def motion() -> SubjectMotion:
    return MOTION


@pytest.fixture(scope="session")
def messages(frames, make_geometry) -> list[Message]:
    """Every topic of the contract, in recorded order: topic, stamp [ns], CDR."""
    twin, rig = TwinEncoder(make_geometry(11)), CommandEncoder()
    whirl = WhirlStateEncoder(make_geometry().mark_names)
    command = Command(weight_on_bit=40.0, rotation=4.0 * np.pi)
    rows = [(topics.TWIN_SCENE, 0, encode_string(SCENE)), (topics.WHIRL_ONSET, 0, encode_onset(0, None))]
    rows.append((topics.COMMANDER, 0, encode_string("/rig_driver")))
    for frame in frames:
        stamp, one = stamp_ns(frame.time), frames_of(frame)
        rows += [
            (topics.RIG_COMMAND, stamp, rig.command(stamp, command)),
            (topics.STRING_POSES, stamp, twin.poses(one)[0]),
            (topics.MARKS_STATE, stamp, twin.marks(one)[0]),
            (topics.RIG_STATE, stamp, twin.rig_state(one)[0]),
            (topics.CLOCK_TOPIC, stamp, twin.clock(one.time)[0]),
            (topics.WHIRL_STATE, stamp, whirl.rows([stamp], np.full((1, 4, 5), frame.time))[0]),
        ]
    stamp = stamp_ns(frames[-1].time)
    rows += [
        (topics.WOB_COMMAND, stamp, rig.wob_command(command)),
        (topics.RPS_COMMAND, stamp, rig.rps_command(command)),
        (topics.STRING_MARKERS, stamp, twin.markers(frames_of(frames[-1]))[0]),
        (topics.WHIRL_MOTION, stamp, encode_motion(stamp, [MOTION])),
        (topics.WHIRL_ONSET, stamp, encode_onset(stamp, ONSET)),
        (topics.DIAGNOSTICS, stamp, encode_diagnostics(stamp, [Status("simulator", Level.OK, "fine")])),
    ]
    return rows


@pytest.fixture
def write_bag(tmp_path, messages) -> Callable[..., Path]:
    """Writes the messages to a new bag; `flush_interval=0` makes a chunk of each one."""

    def write(name: str = "run_0", rows: list[Message] | None = None, **options: object) -> Path:
        with BagWriter(tmp_path / name, **options) as writer:
            for row in messages if rows is None else rows:
                writer.write(*row)
        return writer.folder

    return write
