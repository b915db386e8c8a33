# SPDX-License-Identifier: Apache-2.0
"""Rig driver node: sends weight on bit and top-drive speed, planned or measured, to the simulator.

It follows the simulator's clock: on each `/clock` message it sends the set-points for the end of the next frame. It
thus works at any pace, and a driver that is killed and started again continues at the present simulated time.
"""

from __future__ import annotations

import math
import time
from types import SimpleNamespace
from typing import ClassVar

from rclpy.context import Context

from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.rig_messages import CommandEncoder
from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topics import CLOCK_TOPIC, RIG_COMMAND
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.pacing import Pacer
from drill_twin.ros.core.scene_parameters import scene_of
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.rig_driver.parameters import PARAMETERS
from drill_twin.ros.rig_driver.set_point_transition import Plan, SetPointTransition
from drill_twin.scene.blocks.numerics import frame_period_ns
from drill_twin.scene.set_points.command import Command

_QUIET = 0.1  # s
_REPEAT = 5.0  # s of wall time after which a set-point is sent again, should the simulator have missed it


class RigDriver(TwinNode):
    """Sends set-points: the scene's schedule, or a table of measured ones."""

    NAME: ClassVar = "rig_driver"
    PURPOSE: ClassVar = "Plays weight on bit and top-drive speed, planned or measured, into the simulator."
    PARAMETERS: ClassVar = PARAMETERS

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._encoder = CommandEncoder(self.get_fully_qualified_name())
        self._clock_stamp: int | None = None
        self._sent_stamp = -1
        self._repeat_due = 0.0
        self._sent = 0
        self._last: Command | None = None

    def on_start(self) -> None:
        """Load the schedule and create the topics."""
        from drill_twin.scene.set_points import Schedule

        scene = scene_of(self.settings)
        self._schedule = Schedule.from_scene(scene)
        self._plan: Plan = self._schedule.at
        self._planned = (self.settings.weight_on_bit, self.settings.rotation)
        self._period = frame_period_ns(self.settings.frame_rate or scene.numerics.frame_rate)
        self._pacer = Pacer(seconds(self._period))
        self._plays = scene.name
        if self._schedule.record is not None and scene.rig.table is not None:
            self._plays = str(scene.rig.table.file)
            self.get_logger().info(self._schedule.record.report)
        self.topics.advertise(RIG_COMMAND)
        if self.settings.follow == "clock":
            self.topics.subscribe(CLOCK_TOPIC, self._on_clock, depth=1, latched=True)

    def run(self, stop: StopRequest) -> None:
        """Wait for the other nodes, then send: a reader that is not connected yet would miss the first set-points."""
        self.barrier.wait_for(self.settings.wait_for, self.settings.wait_timeout, stop, self._joins_a_run)
        self.drain(_QUIET)  # a late joiner receives old latched times first
        self.get_logger().info(f"driving: {self._plays}, by the {self.settings.follow}")
        super().run(stop)

    def _joins_a_run(self) -> bool:
        """True where simulated time has begun and the set-points are received: this driver came back during a run."""
        received = self.topics.publishers[RIG_COMMAND].get_subscription_count()
        return bool(self._clock_stamp and received)

    def step(self) -> None:
        """Send the set-points for the next frame, once they are due."""
        if self.settings.follow == "wall":
            self.spin_once(0.0)
            self._clock_stamp = 0 if self._clock_stamp is None else self._clock_stamp + self._period
            self._send(self._clock_stamp + self._period)
            self._pacer.wait()
            return
        if self._clock_stamp is not None:
            stuck = time.monotonic() > self._repeat_due
            if stuck or self._sent_stamp != self._clock_stamp + self._period:
                self._send(self._clock_stamp + self._period)
        self.spin_once(0.05)

    @property
    def finished(self) -> bool:
        """True once the schedule is over, if `at_end` is stop."""
        return self.settings.at_end == "stop" and self._time >= self._schedule.duration

    @property
    def _time(self) -> float:
        return seconds(self._clock_stamp or 0)

    def _on_clock(self, stamp: int) -> None:
        self.samples.take(CLOCK_TOPIC)
        if stamp < (self._clock_stamp or 0):  # the simulator was reset
            self._sent_stamp = -1
            self._plan = self._schedule.at  # as a launch with these set-points: a transition belongs to the run before
        self._clock_stamp = stamp  # `step` sends once all messages are taken: of several, only the last counts

    def _send(self, stamp: int) -> None:
        command = self._plan(seconds(stamp))
        self.topics.publish(RIG_COMMAND, self._encoder.command(stamp, command))
        self._sent_stamp, self._last = stamp, command
        self._repeat_due = time.monotonic() + _REPEAT
        self._sent += 1

    # --- live set-points ------------------------------------------------------------------------------------------

    def check_change(self, settings: SimpleNamespace) -> None:
        """Refuse a set-point that is not valid in the scene."""
        if (settings.weight_on_bit, settings.rotation) != self._planned:
            scene_of(settings)

    def on_change(self) -> None:
        """Start the transition to the new set-points."""
        from drill_twin.scene.set_points import Schedule

        wanted = (self.settings.weight_on_bit, self.settings.rotation)
        if wanted == self._planned:
            return
        self._planned = wanted
        self._schedule = Schedule.from_scene(scene_of(self.settings))
        self._plan = self._schedule.at
        if self._last is not None:
            self._plan = SetPointTransition(self._last, self._schedule.at, self._time, self.settings.change_time)
        self.get_logger().info(f"from {self._time:.2f} s: weight on bit {wanted[0]!r}, speed {wanted[1]!r}")

    # --- end and health -------------------------------------------------------------------------------------------

    def on_stop(self) -> None:
        """Wait until the last set-point has been received."""
        if self._sent:
            self.publish_diagnostics()
            self.topics.flush(1.0)

    def health(self) -> Status:
        """Set-points in force, and other drivers."""
        command = self._last or Command(0.0, 0.0)
        over = self._time >= self._schedule.duration
        drivers = self.topics.publisher_nodes(RIG_COMMAND)
        values = {
            "plays": self._plays,
            "time": f"{self._time:.3f}",
            "schedule_ends": f"{self._schedule.duration:.3f}",
            "weight_on_bit": f"{command.weight_on_bit:g}",
            "speed_rev_s": f"{command.rotation / math.tau:g}",
            "commands_sent": str(self._sent),
            **self.samples.values(),
        }
        level, text = self.samples.verdict()
        if len(drivers) > 1:
            return Status(self.NAME, Level.WARN, f"more than one driver: {', '.join(drivers)}", values)
        if self._clock_stamp is None and level is Level.OK:
            return Status(self.NAME, Level.OK, f"waiting for {CLOCK_TOPIC}", values)
        return Status(self.NAME, level, text or ("the schedule is over; holding" if over else "driving"), values)
