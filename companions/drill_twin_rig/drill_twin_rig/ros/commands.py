# SPDX-License-Identifier: Apache-2.0
"""Set-points of the gateway on `/rig/command`; once it sends none the simulator goes to its safe set-point."""

import threading
from collections.abc import Mapping

from drill_twin.io.messages.rig_messages import CommandEncoder
from drill_twin.io.messages.topics import RIG_COMMAND
from drill_twin.ros.core.node import TwinNode
from drill_twin.scene.set_points.command import Command
from drill_twin_rig.gateway.quantities import TwinQuantities


class CommandOutput:
    """Publisher of set-points; `send` may be called from any thread."""

    def __init__(self, node: TwinNode, quantities: TwinQuantities) -> None:
        self._node, self._quantities = node, quantities
        self._encoder = CommandEncoder(node.get_fully_qualified_name())
        self._lock = threading.Lock()
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
            self.command = Command(values.get("weight_on_bit", 0.0), values.get("surface_rotation", 0.0))

    def send(self, wanted: Mapping[str, float]) -> None:
        """Send set-points, by quantity [SI]; a set-point that is missing stays, and is sent again.

        Called at a rate with none, so that nobody takes the gateway for silent.
        """
        with self._lock:
            if self.command is None:
                return
            self.command = self.command._replace(
                weight_on_bit=wanted.get("weight_on_bit", self.command.weight_on_bit),
                rotation=wanted.get("surface_rotation", self.command.rotation),
            )
            self._node.topics.publish(RIG_COMMAND, self._encoder.command(self._quantities.stamp, self.command))
            self.sent += 1

    def end(self) -> None:
        """End commanding: others may, and where nobody does the simulator finds its commander lost."""
        with self._lock:
            self.command = None
        if RIG_COMMAND in self._node.topics.publishers:
            self._node.topics.withdraw(RIG_COMMAND)
