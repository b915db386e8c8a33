# SPDX-License-Identifier: Apache-2.0
"""Set-points of the gateway on `/rig/command`, and the safe one after a loss of control."""

import threading
import time
from collections.abc import Mapping
from dataclasses import replace

from drill_twin.io.messages.rig_messages import CommandEncoder
from drill_twin.io.messages.topics import RIG_COMMAND
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.rig_driver.plan import SetPointTransition
from drill_twin.scene.set_points.command import Command
from drill_twin_rig.gateway.quantities import TwinQuantities


class CommandOutput:
    """Publisher of set-points; `send` may be called from any thread."""

    def __init__(self, node: TwinNode, quantities: TwinQuantities) -> None:
        self._node, self._quantities = node, quantities
        self._encoder = CommandEncoder(node.get_fully_qualified_name())
        self._lock = threading.Lock()
        self._to_safe: SetPointTransition | None = None
        self.command: Command | None = None
        """Set-point in force; None while the gateway does not command."""
        self.sent = 0
        """Commands sent."""

    def others(self) -> list[str]:
        """Names of the other nodes that command."""
        names = self._node.topics.publisher_nodes(RIG_COMMAND)
        return [name for name in names if name != self._node.get_fully_qualified_name()]

    def begin(self) -> None:
        """Begin to command, with the set-point that the twin has now."""
        if RIG_COMMAND not in self._node.topics.publishers:
            self._node.topics.advertise(RIG_COMMAND)
        values = self._quantities.values
        with self._lock:
            self._to_safe = None
            self.command = Command(values.get("weight_on_bit", 0.0), values.get("surface_rotation", 0.0))

    def send(self, wanted: Mapping[str, float]) -> None:
        """Send set-points at once, by quantity [SI]; a set-point that is missing stays."""
        with self._lock:
            if self.command is None or self._to_safe is not None:
                return
            self.command = replace(
                self.command,
                weight_on_bit=wanted.get("weight_on_bit", self.command.weight_on_bit),
                rotation=wanted.get("surface_rotation", self.command.rotation),
            )
            self._publish()

    def go_safe(self) -> None:
        """Go to the safe set-point of the parameters within their ramp time, by the wall clock, and hold it."""
        settings = self._node.settings
        safe = Command(settings.safe_weight_on_bit, settings.safe_speed)
        with self._lock:
            if self.command is not None:
                begin = time.monotonic()
                self._to_safe = SetPointTransition(self.command, lambda _: safe, begin, settings.safe_ramp_time)

    def end(self) -> None:
        """End commanding: others may."""
        with self._lock:
            self.command = self._to_safe = None
        if RIG_COMMAND in self._node.topics.publishers:
            self._node.topics.withdraw(RIG_COMMAND)

    def repeat(self) -> None:
        """Send the set-point in force again, so that nobody takes the gateway for silent."""
        with self._lock:
            if self._to_safe is not None:
                self.command = self._to_safe(time.monotonic())
            if self.command is not None:
                self._publish()

    @property
    def is_safe(self) -> bool:
        """True from a loss of control until the gateway begins to command again."""
        return self._to_safe is not None

    def _publish(self) -> None:
        if self.command is not None:
            self._node.topics.publish(RIG_COMMAND, self._encoder.command(self._quantities.stamp, self.command))
            self.sent += 1
