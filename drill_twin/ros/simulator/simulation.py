# SPDX-License-Identifier: Apache-2.0
"""A configured run of the simulator: commands in, a frame of the twin, messages out, and checkpoints of its state.

The twin's tf is published where tf2_msgs is installed: in a whole ROS 2, not with the wheels.
"""

import os
import threading
import time
from datetime import UTC, datetime
from pathlib import Path

from rclpy.logging import get_logging_directory

from drill_twin.core.errors import CheckpointError, RunError, StoppedError
from drill_twin.dynamics.twin.checkpoint import Checkpoint, save_failure
from drill_twin.dynamics.twin.frame import Frame
from drill_twin.io.messages.drawing.transforms import StringTransforms, static_message
from drill_twin.io.messages.encode import encode_string
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.messages.topics import COMMANDER, OF_TF, TF, TF_STATIC
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.pacing import Pacer, Tick
from drill_twin.ros.core.topics import installed
from drill_twin.ros.simulator.command_arbiter import CommandArbiter
from drill_twin.ros.simulator.command_limits import CommandStamps
from drill_twin.ros.simulator.start_up import CheckpointPlaces
from drill_twin.runs.loop import RunLoop
from drill_twin.scene import Scene
from drill_twin.scene.blocks.numerics import frame_period
from drill_twin.scene.set_points.command import Command

_ASK_AGAIN = 2.0  # s of wall time without a frame; rare on a busy machine with all connected
_WHEN_LATE = 20  # messages between two late frames: twice what the queue of commands holds, 2 ms in a flood
_LOOK = 0.01  # s between two looks at what has come, where there is no wait
_BURST = 200  # frames; as fast as possible must not be faster than the readers


class CheckpointWriter:
    """Writes one checkpoint at a time, in a thread: a slow disk delays no frame, but leaves out the next checkpoint."""

    def __init__(self) -> None:
        self._writing: threading.Thread | None = None
        self.written: float | None = None
        """Simulated time of the last checkpoint on the disk [s]; None without one."""
        self.trouble = ""
        """Reason why the last checkpoint could not be written; empty when it was."""

    def start(self, checkpoint: Checkpoint, path: Path) -> None:
        """Start to write a checkpoint, unless another is being written."""
        if self._writing is not None and self._writing.is_alive():
            return
        self._writing = threading.Thread(target=self._write, args=(checkpoint, path), name="checkpoint")
        self._writing.start()

    def finish(self) -> None:
        """Wait until the checkpoint is written that was started last."""
        if self._writing is not None:
            self._writing.join()

    def _write(self, checkpoint: Checkpoint, path: Path) -> None:
        try:
            checkpoint.save(path)
        except CheckpointError as error:
            self.trouble = str(error)
            return
        self.written, self.trouble = checkpoint.time, ""


class SimulatorRun:
    """The run loop of a node, its commands, its pace and its checkpoints.

    Attributes:
        loop: The run loop with the twin; its sink is DDS.
        commands: The commands.
        pacer: Holds frames to wall time.
        checkpoints: Writes checkpoints in the background.
    """

    def __init__(self, node: TwinNode, scene: Scene, frame_rate: float, places: CheckpointPlaces) -> None:
        """Build the twin, whose kernels have been compiled.

        Args:
            node: The simulator node, with its publishers.
            scene: The scene.
            frame_rate: Frames per simulated second [Hz].
            places: Where checkpoints may be written.
        """
        self._node, self.places = node, places
        period = frame_period(frame_rate)
        self.loop = RunLoop(
            scene, period, node.topics.publish, pace=node.settings.pace, frame_prefix=node.settings.frame_prefix
        )
        stamps = CommandStamps(node.settings.pace, stamp_ns(period), lambda: stamp_ns(self.loop.twin.time))
        self.commands = CommandArbiter(scene, node.settings, stamps)
        self.pacer, self._look = Pacer(period), Tick(_LOOK)
        self._frame_at, self._ask = time.monotonic(), Tick(_ASK_AGAIN)  # when the last frame was due
        self.checkpoints = CheckpointWriter()
        self._commander: str | None = None  # as last told
        self._transforms = StringTransforms(self.loop.geometry) if installed(TF) else None
        if self._transforms is not None:
            for topic in OF_TF:
                node.topics.advertise(topic)
            node.topics.publish(TF_STATIC, static_message(scene.hole.top_inclination, node.settings.frame_prefix))
        self._markers: Tick | None = None
        self._checkpoint_due: Tick | None = None

    def apply_settings(self) -> None:
        """Apply the node's settings, of which one may have changed."""
        settings = self._node.settings
        self.commands.set_limits()
        self._markers = Tick(1.0 / settings.marker_rate) if settings.marker_rate else None
        periodic = settings.checkpoint and settings.checkpoint_period
        self._checkpoint_due = Tick(settings.checkpoint_period) if periodic else None

    @property
    def time_text(self) -> str:
        """Simulated time in words."""
        return f"t = {self.loop.twin.time:.6g} s"

    @property
    def complete(self) -> bool:
        """True once the duration that was asked for has been simulated."""
        wanted = self._node.settings.duration
        return bool(wanted) and self.loop.twin.time >= wanted - 0.5 * self.loop.period

    @property
    def waits_for_command(self) -> bool:
        """True while time stands still for a command: for the first one, or in lockstep for the next."""
        settings = self._node.settings
        if not self.loop.frames and settings.wait_for_command and not self.commands.heard:
            return True
        return settings.pace == "lockstep" and bool(self.commands.awaited)

    @property
    def waited(self) -> float:
        """Wall time since simulated time began to stand still for a command [s]."""
        return time.monotonic() - self._frame_at

    def tell_commander(self) -> None:
        """Publish who commands, if another does."""
        if (commander := self.commands.commander) != self._commander:
            self._commander = commander
            self._node.topics.publish(COMMANDER, encode_string(commander))

    def advance(self) -> None:
        """Compute and publish a frame.

        Raises:
            RunError: The motion could not be followed; the last good state is saved.
        """
        self._frame_at = time.monotonic()
        command = self.commands.set_point(self.loop.period)
        exaggeration = self._node.settings.exaggeration or None
        markers = self._markers_due()
        try:
            self.loop.advance(
                command, markers=markers, exaggeration=exaggeration, also=self._send_transforms if markers else None
            )
        except StoppedError as error:
            raise RunError(f"{error}; {self._save_failure(command, error)}") from error
        if self._checkpoint_due is not None and self._checkpoint_due.due():
            self.keep()

    def _send_transforms(self, frame: Frame) -> None:
        if self._transforms is not None:
            self._node.topics.publish(TF, self._transforms.message(frame))

    def keep_pace(self, *, steps: bool = False) -> None:
        """Process what comes until the next frame is due; the frames of a step are due as fast as possible."""
        pace = "fast" if steps else self._node.settings.pace
        if pace == "realtime":
            if not self.pacer.wait(self._node.spin_once):
                self._node.spin_all(_WHEN_LATE)
        elif pace == "fast":
            if self.loop.frames % _BURST == 0:
                self._node.flush(1.0)
            if self._look.due():
                self._node.spin_all()

    def stand_still(self, *, paused: bool) -> None:
        """Let wall time pass without a frame; it counts in the real-time factor unless it is a pause.

        While a command is missing, the time is told again: whoever commands by it may not have been connected before.
        """
        self.pacer.restart()
        if paused or not self.loop.frames:
            self.loop.timing.pause()
        if paused:
            self._frame_at = time.monotonic()
        elif self.waited > _ASK_AGAIN and self._ask.due():
            self.loop.tell_time()

    def reset(self) -> None:
        """Start a new run at time zero."""
        self.commands.begin()
        self.pacer.restart()
        self.loop.reset()

    def keep(self) -> None:
        """Begin to write the periodic checkpoint; the diagnostics tell where its place is refused."""
        try:
            self.checkpoints.start(self.checkpoint(), self.places.file(self._node.settings.checkpoint))
        except CheckpointError as error:
            self.checkpoints.trouble = str(error)

    def checkpoint(self) -> Checkpoint:
        """State of the run, with the set-points in force."""
        return Checkpoint.of(self.loop.twin, self.commands.kept)

    def resume(self, path: Path) -> None:
        """Go on from a checkpoint file.

        Raises:
            CheckpointError: The file cannot be read, is of another scene, or of a time at which the run was over.
        """
        self.checkpoints.finish()
        checkpoint = Checkpoint.load(path)
        duration = self._node.settings.duration
        if duration and checkpoint.time >= duration - 0.5 * self.loop.period:
            raise CheckpointError(
                f"{path}: expected a checkpoint before the duration of {duration:g} s, found one at "
                f"{checkpoint.time:g} s, where the run was over; move it away, or simulate for longer"
            )
        self.loop.resume(checkpoint)
        self.commands.go_on(checkpoint.command)
        self.pacer.restart()
        self._node.get_logger().info(f"going on from {path} at {checkpoint.time:.6g} s")

    def close(self) -> None:
        """Write the last checkpoint, and report how the run went."""
        self.checkpoints.finish()
        if not self.loop.frames and not self.loop.rejected_steps.stopped:
            return
        node = self._node
        if self._checkpoint_due is not None:
            self.keep()
            self.checkpoints.finish()
        if self.checkpoints.trouble:
            node.get_logger().error(f"no checkpoint: {self.checkpoints.trouble}")
        node.publish_diagnostics()
        node.flush()
        node.get_logger().info(f"{self.loop.twin.time:.2f} s simulated, {self.loop.timing.text()}")

    def _markers_due(self) -> bool:
        """In lockstep by simulated time, so that runs are alike; else by wall time, as markers are for viewers."""
        settings = self._node.settings
        if settings.pace != "lockstep" or self._markers is None:
            return self._markers is not None and self._markers.due()
        every = max(round(1.0 / (self.loop.period * float(settings.marker_rate))), 1)
        return self.loop.frames % every == 0

    def _save_failure(self, command: Command, error: StoppedError) -> str:
        """Save the last good state beside the checkpoint, else in the folder of the logs; returns where, in words."""
        self.checkpoints.finish()
        beside = self._node.settings.checkpoint
        folder = Path(beside).parent if beside else Path(get_logging_directory())
        name = f"{self._node.get_name()}_stop_{datetime.now(UTC):%Y%m%dT%H%M%S}_{os.getpid()}"
        return save_failure(folder / name, self.loop.twin, command, error)
