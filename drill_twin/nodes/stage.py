# SPDX-License-Identifier: Apache-2.0
"""The twin on its stage: takes a frame, publishes what it looks like, and counts what that cost."""

from __future__ import annotations

import time
from collections.abc import Mapping

from rclpy.publisher import Publisher

from drill_twin.checkpoint import Checkpoint
from drill_twin.cost import Cost
from drill_twin.frame import Frame
from drill_twin.messages.encode import TwinEncoder, encode_string
from drill_twin.messages.topics import (
    CLOCK_TOPIC,
    MARKS_STATE,
    RIG_STATE,
    STRING_MARKERS,
    STRING_POSES,
    TWIN_SCENE,
)
from drill_twin.omissions import Omissions
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.twin import Twin
from drill_twin.wiring import describe_run, string_geometry

TOPICS_OF_STAGE = (RIG_STATE, STRING_POSES, MARKS_STATE, STRING_MARKERS, TWIN_SCENE)
"""What it publishes, but for `/clock`."""


class Stage:
    """A twin and its audience."""

    def __init__(self, scene: Scene, period: float, pace: str, send: Mapping[str, Publisher]) -> None:
        """Compile and build the twin.

        Args:
            scene: What is drilled.
            period: Simulated time of a frame [s].
            pace: Pace of the simulator, for the description of the run.
            send: Publishers by topic.
        """
        self.scene = scene
        self.period = period
        self.first = Command(scene.rig.weight_on_bit.initial, scene.rig.rotation.initial)
        self.cost = Cost()
        self.omissions = Omissions(scene)
        self.frame: Frame | None = None
        self.frames = 0
        self._pace = pace
        self._send = send
        # A first frame of another twin compiles the kernel: time must not stand still once it runs.
        Twin(scene).step(self.first, period)
        self.twin = Twin(scene)
        self._encoder = TwinEncoder(string_geometry(scene, self.twin.elements))

    def announce(self) -> None:
        """Publish the run's description and its time: of a new run, or of one that goes on from a checkpoint."""
        self._send[TWIN_SCENE].publish(encode_string(describe_run(self.twin, self._pace)))
        self._send[CLOCK_TOPIC].publish(self._encoder.clock(self.twin.time))

    def reset(self) -> None:
        """Begin again at time zero."""
        self.twin = Twin(self.scene)
        self.frame, self.frames = None, 0
        self.omissions = Omissions(self.scene)
        self.announce()

    def go_on_from(self, checkpoint: Checkpoint) -> None:
        """Go on from a checkpoint.

        Raises:
            CheckpointError: It is of another scene.
        """
        checkpoint.restore(self.twin)
        self.frames = round(self.twin.time / self.period)

    def advance(self, command: Command, *, picture: bool, exaggeration: float) -> None:
        """Take a frame and publish it."""
        begin = time.perf_counter()
        frame = self.twin.step(command, self.period)
        stepped = time.perf_counter()
        send, encoder = self._send, self._encoder
        send[RIG_STATE].publish(encoder.rig_state(frame))
        send[MARKS_STATE].publish(encoder.marks(frame))
        send[STRING_POSES].publish(encoder.poses(frame))
        if picture:
            send[STRING_MARKERS].publish(encoder.markers(frame, exaggeration or None))
        # Last: who answers the clock can rely on the frame being out.
        send[CLOCK_TOPIC].publish(encoder.clock(frame.time))
        self.frame = frame
        self.frames += 1
        self.cost.add(self.period, stepped - begin, time.perf_counter() - stepped, frame)
        self.omissions.look(frame)
