# SPDX-License-Identifier: Apache-2.0
"""Rig driver node: sends weight on bit and top-drive speed, planned or measured, to the simulator.

The node follows the simulator's clock: on each `/clock` message it sends the set-points for the end of the next
frame. It thus works at any pace, and a driver that is killed and started again continues at the present simulated time.
While several nodes publish `/clock`, the driver goes on to send the last set-point; a simulator that was killed is not
counted.
"""

import math
import time
from types import SimpleNamespace

from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.rig_messages import CommandEncoder
from drill_twin.io.messages.stamps import NANOSECONDS, seconds, within_range
from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS, RIG_COMMAND
from drill_twin.ros.core.node import AUTOSTART, TwinNode
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.core.policy import READY, Rights
from drill_twin.ros.core.scene_parameters import OVERRIDES, SCENE
from drill_twin.ros.core.startup_barrier import StartupBarrier
from drill_twin.ros.rig_driver.clock_source import ClockSource
from drill_twin.ros.rig_driver.plan import SetPointPlan, check_set_points
from drill_twin.scene.set_points.command import Command

_QUIET = 0.1  # s
_CROSSED = 1.0  # s; a time that is told again within it, as by a simulator that waits, crossed with the answer to it
_REPEAT = 5.0  # s of wall time after which a set-point is sent again, should the simulator have missed it


class RigDriver(TwinNode):
    """Sends set-points: the scene's schedule, or a table of measured ones."""

    NAME = "rig_driver"
    PURPOSE = "Plays weight on bit and top-drive speed, planned or measured, into the simulator."
    PARAMETERS = (
        SCENE,
        Parameter(
            "wob",
            "",
            "weight on bit in place of the scene's; \"\": the scene's",
            "N",
            live=True,
            such_as="40 N",
        ),
        Parameter(
            "rpm",
            "",
            "top-drive speed in place of the scene's; \"\": the scene's",
            "rad/s",
            live=True,
            such_as="120 rpm",
        ),
        Parameter(
            "change_time", 1.0, "simulated time that a live change of a set-point takes", "s", 0.0, 3600.0, live=True
        ),
        Parameter(
            "table",
            "",
            "CSV, MAT, LAS or WITSML file of measured set-points to play in place of the schedule; its columns and "
            "units are named by rig.table in the scene (or overrides), or are found by their names; "
            '"": the scene\'s schedule',
        ),
        OVERRIDES,
        Parameter(
            "follow",
            "clock",
            "clock: send with the simulator's /clock; wall: send and stamp by the wall clock, where there is no /clock",
            choices=("clock", "wall"),
        ),
        Parameter("frame_rate", 0.0, "set-points per second; 0: the scene's frame rate", "Hz", 0.0, 1000.0),
        Parameter("wait_for", ("simulator",), "nodes that must be ready before the first set-point"),
        Parameter("wait_timeout", 120.0, "longest wait for nodes", "s", 0.0, 3600.0),
        Parameter(
            "at_end",
            "hold",
            "hold: go on sending the last set-point when the schedule is over; stop: end the node",
            choices=("hold", "stop"),
            live=True,
        ),
        AUTOSTART,
    )
    RIGHTS = Rights((CLOCK_TOPIC, DIAGNOSTICS), calls=READY)
    _sent = 0

    def configure(self) -> None:
        """Load the schedule; create publishers, the subscription to the clock, and the wait for other nodes."""
        self._plan = SetPointPlan(self.settings)
        self._encoder = CommandEncoder(self.get_fully_qualified_name())
        self._clock_stamp: int | None = None  # ns
        self._last: Command | None = None
        self._sent, self._sent_stamp, self._sent_at = 0, -1, math.inf
        if self._plan.report:
            self.get_logger().info(self._plan.report)
        self.topics.advertise(RIG_COMMAND)
        if self.settings.follow == "clock":
            self._simulated_clock = ClockSource(self.topics, self._on_clock, self._hold)
            self.every(1.0, self._repeat)
            self.samples.expect(CLOCK_TOPIC)
        else:
            self.every(seconds(self._plan.period), self._on_wall)
        self._barrier = StartupBarrier(
            self, " ".join(self.settings.wait_for), self.settings.wait_timeout, self._joins_a_run
        )
        self._drives = self._holds = False

    def complete(self) -> None:
        """Wait until the last set-point has been received."""
        if self._sent:
            self.publish_diagnostics()
            self.flush(1.0)

    def step(self) -> None:
        """Wait for the other nodes first: a reader that is not connected yet would miss the first set-points."""
        if not self._drives and self._barrier.passed():
            self.drain(_QUIET)  # a late joiner receives old latched times first
            self.get_logger().info(f"driving: {self._plan.plays}, by the {self.settings.follow}")
            self._drives, self._begun = True, time.monotonic()
            if self._clock_stamp is not None:
                self._send(self._clock_stamp)
        self.spin_once(0.05)

    def not_ready(self) -> str:
        """Reason why it does not drive yet; empty when it does."""
        return "" if self._drives else "it waits for other nodes"

    def _joins_a_run(self) -> bool:
        """True where simulated time has begun and the set-points are received: this driver came back during a run."""
        return bool(self._clock_stamp and self.topics.publishers[RIG_COMMAND].get_subscription_count())

    def _on_clock(self, stamp: int) -> None:
        self.samples.take(CLOCK_TOPIC)
        if stamp < (self._clock_stamp or 0):  # the simulator was reset
            self._sent_stamp = -1
            self._plan.begin_again()
        self._clock_stamp, self._holds = stamp, False
        if self._sent_stamp != stamp + self._plan.period or time.monotonic() - self._sent_at > _CROSSED:
            self._send(stamp)

    def _hold(self) -> None:
        """Send the last set-point again, without a stamp: which clock is the simulator's is not known."""
        self.samples.take(CLOCK_TOPIC)
        if not self._holds:
            self._holds = True
            self.publish_diagnostics()
        if self._last is not None and self.active:
            self._publish(0, self._last)

    def _repeat(self) -> None:
        self._simulated_clock.settle()
        if self._clock_stamp is not None and time.monotonic() - self._sent_at > _REPEAT:
            self._send(self._clock_stamp)

    def _on_wall(self) -> None:
        if self._drives:
            self._clock_stamp = (
                int((time.monotonic() - self._begun) * NANOSECONDS) // self._plan.period * self._plan.period
            )
            self._send(self._clock_stamp)

    def _send(self, clock: int) -> None:
        """Send the set-points for the end of the frame that begins at this time [ns]."""
        if not self._drives or not self.active:  # the clock is latched, so it comes at rest too
            return
        end = within_range(clock + self._plan.period)
        by_clock = self.settings.follow == "clock"
        stamp = end if by_clock else within_range(self.get_clock().now().nanoseconds)
        self._publish(stamp, self._plan.at(seconds(end)))

    def _publish(self, stamp: int, command: Command) -> None:
        self.topics.publish(RIG_COMMAND, self._encoder.command(stamp, command))
        self._last, self._sent_stamp, self._sent_at = command, stamp, time.monotonic()
        self._sent += 1

    @property
    def finished(self) -> bool:
        """True once the schedule is over, if `at_end` is stop."""
        return self.settings.at_end == "stop" and self._drives and self._time >= self._plan.schedule.duration

    @property
    def _time(self) -> float:
        return seconds(self._clock_stamp or 0)

    def check_change(self, settings: SimpleNamespace) -> None:
        """Refuse a live set-point that is not valid in the scene."""
        check_set_points(settings, self.settings)

    def on_change(self) -> None:
        """Start the transition to the new set-points."""
        weight, speed = (text or "as in the scene" for text in (self.settings.wob, self.settings.rpm))
        if self._plan.change(self.settings, self._last, self._time):
            self.get_logger().info(f"from {self._time:.2f} s: weight on bit {weight}, speed {speed}")

    def health(self) -> Status:
        """Set-points in force, and other drivers."""
        command = self._last or Command(0.0, 0.0)
        over = self._time >= self._plan.schedule.duration
        drivers = self.topics.publisher_nodes(RIG_COMMAND)
        values = {
            "plays": self._plan.plays,
            "time": f"{self._time:.3f}",
            "schedule_ends": f"{self._plan.schedule.duration:.3f}",
            "weight_on_bit": f"{command.weight_on_bit:g}",
            "speed_rev_s": f"{command.rotation / math.tau:g}",
            "commands_sent": str(self._sent),
            **self.samples.values(),
        }
        rivals = f"more than one driver: {', '.join(drivers)}" if len(drivers) > 1 else ""
        state = self.not_ready() or ("the schedule is over; holding" if over else "driving")
        return self.status(values, (Level.WARN, rivals), self.samples.verdict(), (Level.OK, state))
