# SPDX-License-Identifier: Apache-2.0
"""The twin on its stage: takes a frame, publishes what it looks like, and counts what that cost."""

from __future__ import annotations

import time
from collections.abc import Mapping

from rclpy.node import Node
from rclpy.publisher import Publisher

from drill_twin.errors import RunError
from drill_twin.io.adapters import describe_run, string_geometry
from drill_twin.io.messages.encode import TwinEncoder, encode_string
from drill_twin.io.messages.topics import (
    CLOCK_TOPIC,
    MARKS_STATE,
    RIG_STATE,
    STRING_MARKERS,
    STRING_POSES,
    TWIN_SCENE,
)
from drill_twin.monitor.drilling_progress import DrillingProgress
from drill_twin.monitor.missing_effects import MissingEffects
from drill_twin.monitor.rejected_steps import RejectedSteps
from drill_twin.monitor.run_timing import EffectTiming, RunTiming
from drill_twin.ros.simulator.tf_publisher import Transforms, tf_message
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command
from drill_twin.twin.checkpoint import Checkpoint
from drill_twin.twin.frame import Frame
from drill_twin.twin.twin import Twin

TOPICS_OF_TWIN = (RIG_STATE, STRING_POSES, MARKS_STATE, STRING_MARKERS, TWIN_SCENE)
"""What it publishes, but for `/clock`."""


class TwinPublisher:
    """A twin and its audience."""

    def __init__(self, node: Node, scene: Scene, period: float, pace: str, send: Mapping[str, Publisher]) -> None:
        """Compile and build the twin.

        Args:
            node: Whose stage it is.
            scene: What is drilled.
            period: Simulated time of a frame [s].
            pace: Pace of the simulator, for the description of the run.
            send: Publishers by topic.
        """
        self.scene = scene
        self.period = period
        self.first = Command(*scene.rig.first)
        self.cost = RunTiming()
        self.omissions = MissingEffects(scene)
        self.interventions = RejectedSteps()
        self.frame: Frame | None = None
        self.frames = 0
        self._pace = pace
        self._send = send
        # A first frame of another twin compiles the kernel: time must not stand still once it runs.
        Twin(scene).advance(self.first, period)
        self.twin = Twin(scene)
        self.effect_cost = EffectTiming(self.twin)
        self.drilled = DrillingProgress(self.twin)
        geometry = string_geometry(self.twin)
        self._encoder = TwinEncoder(geometry)
        kind = tf_message()
        self._transforms = None if kind is None else Transforms(node, kind, geometry, scene.hole.top_inclination)

    def retire(self) -> None:
        """Take back what is published beside the topics of the contract."""
        if self._transforms is not None:
            self._transforms.retire()

    def announce(self) -> None:
        """Publish the run's description and its time: of a new run, or of one that goes on from a checkpoint."""
        self._send[TWIN_SCENE].publish(encode_string(describe_run(self.twin, self._pace)))
        self._send[CLOCK_TOPIC].publish(self._encoder.clock(self.twin.time))

    def reset(self) -> None:
        """Begin again at time zero."""
        self.twin = Twin(self.scene)
        self.effect_cost = EffectTiming(self.twin)
        self.drilled = DrillingProgress(self.twin)
        self.frame, self.frames = None, 0
        self.omissions = MissingEffects(self.scene)
        self.interventions = RejectedSteps()
        self.announce()

    def go_on_from(self, checkpoint: Checkpoint) -> None:
        """Go on from a checkpoint.

        Raises:
            CheckpointError: It is of another scene.
        """
        checkpoint.restore(self.twin)
        self.interventions = RejectedSteps()
        self.drilled = DrillingProgress(self.twin)
        self.frames = round(self.twin.time / self.period)

    def advance(self, command: Command, *, picture: bool, exaggeration: float) -> None:
        """Take a frame and publish it.

        Raises:
            RunError: It could not be done; the twin is at the last good frame.
        """
        begin = time.perf_counter()
        try:
            frame = self.twin.advance(command, self.period)
        except RunError as error:
            self.interventions.stopped = str(error)
            raise
        stepped = time.perf_counter()
        send, encoder = self._send, self._encoder
        send[RIG_STATE].publish(encoder.rig_state(frame))
        send[MARKS_STATE].publish(encoder.marks(frame))
        send[STRING_POSES].publish(encoder.poses(frame))
        if picture:
            send[STRING_MARKERS].publish(encoder.markers(frame, exaggeration or None))
            if self._transforms is not None:
                self._transforms.publish(frame)
        # Last: who answers the clock can rely on the frame being out.
        send[CLOCK_TOPIC].publish(encoder.clock(frame.time))
        self.frame = frame
        self.frames += 1
        self.cost.update(self.period, stepped - begin, time.perf_counter() - stepped, frame)
        self.omissions.update(frame)
        self.interventions.update(frame)
