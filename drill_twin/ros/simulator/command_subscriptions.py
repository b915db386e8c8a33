# SPDX-License-Identifier: Apache-2.0
"""Where commands come in from the topics: read, checked against a time that went back, and handed to the desk."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from drill_twin.errors import MessageError
from drill_twin.io.messages.decode import JointStateReader, read_float64
from drill_twin.io.messages.encode import read_command
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.messages.topics import RIG_COMMAND, RPS_COMMAND, WOB_COMMAND
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.node_topics import NOT_NAMED_YET
from drill_twin.ros.core.topic_qos import relative
from drill_twin.ros.simulator.command_arbiter import CommandArbiter, Silence
from drill_twin.ros.simulator.command_limits import limits_for
from drill_twin.scene import Scene
from drill_twin.schedule.command import Command

_AHEAD = 1_000_000_000  # ns; a command stamped later than this is not for the frames to come


class CommandSubscriptions:
    """The command topics of a simulator, and the desk behind them.

    Attributes:
        desk: Judges the commands and holds the set-point.
    """

    def __init__(self, node: TwinNode, scene: Scene, first: Command, now: Callable[[], float]) -> None:
        """Open the desk; `listen` opens the door.

        Args:
            node: The simulator.
            scene: What is drilled: it says which commands can be meant.
            first: Set-points before the first command.
            now: Simulated time [s].
        """
        self._node, self._scene, self._first, self._now = node, scene, first, now
        self._read_command = JointStateReader().read
        self._drivers_topic = node.resolve_topic_name(relative(RIG_COMMAND))
        self._went_back = False
        self.desk = CommandArbiter(*self._rules(), first)

    def listen(self) -> None:
        """Subscribe."""
        self._node.topics.subscribe(RIG_COMMAND, self._on_command)
        self._node.topics.subscribe(WOB_COMMAND, lambda raw, _: self._on_single(raw, self.desk.weight_on_bit))
        self._node.topics.subscribe(RPS_COMMAND, lambda raw, _: self._on_single(raw, self.desk.speed))

    def follow_settings(self) -> None:
        """Go by the node's settings of now."""
        self.desk.rule(*self._rules())

    def begin_again(self, command: Command | None = None) -> None:
        """Time went back, or to a checkpoint where this command was in force: what is under way is of before."""
        self.desk = CommandArbiter(*self._rules(), self._first)
        self._went_back = True
        if command is not None:
            self.desk.go_on_with(command)

    def sources(self) -> list[str]:
        """Who commands: all publishers of `/rig/command`, and those of single values who are none of these.

        A driver announces `/rig/command` first, so it is asked for last: else one that comes in between would look
        like somebody with single values.
        """
        of = self._node.topics.publisher_nodes
        singles = {*of(WOB_COMMAND), *of(RPS_COMMAND)}
        drivers = of(RIG_COMMAND)
        return [name for name in (*drivers, *sorted(singles - set(drivers))) if name != NOT_NAMED_YET]

    def _rules(self) -> tuple[Any, Silence]:
        settings: SimpleNamespace = self._node.settings
        limits = limits_for(
            self._scene,
            max_weight_on_bit=settings.max_weight_on_bit,
            max_speed=settings.max_speed * math.tau,
            negative=settings.negative_commands,
        )
        safe = Command(settings.safe_weight_on_bit, settings.safe_speed * math.tau)
        return limits, Silence(settings.command_timeout, settings.on_silence == "ramp", safe, settings.safe_ramp_time)

    def _on_command(self, raw: bytes, info: Mapping[str, Any]) -> None:
        del info
        try:
            state = self._read_command(raw)
            command = read_command(state)
        except MessageError as error:
            self.desk.malformed(str(error))
            return
        ahead = state.stamp - stamp_ns(self._now())
        if ahead > _AHEAD:
            if self._went_back:  # it was under way when time went back
                return
            if self._node.settings.pace == "lockstep":  # it would set free all frames until then
                self.desk.malformed(
                    f"expected a command stamped for the next frames, found one {ahead * 1e-9:g} s ahead"
                )
                return
        self._went_back = False
        self.desk.both(state.stamp, command)

    def _on_single(self, raw: bytes, deliver: Callable[..., None]) -> None:
        try:
            value = read_float64(raw)
        except MessageError as error:
            self.desk.malformed(str(error))
            return
        deliver(value, driver_present=self._node.count_publishers(self._drivers_topic) > 0)
