# SPDX-License-Identifier: Apache-2.0
"""Control at the gateway: the decision who commands, the set-points on `/rig/command`, and a safe one after a loss."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from std_srvs.srv import Trigger

from drill_twin.io.messages.rig_messages import CommandEncoder
from drill_twin.io.messages.topics import RIG_COMMAND
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.rig_driver.plan import SetPointTransition
from drill_twin.scene.set_points.command import Command
from drill_twin_rig.gateway.control import Control, Permission
from drill_twin_rig.gateway.quantities import TwinQuantities

if TYPE_CHECKING:
    from drill_twin_rig.gateway.opc_ua.server import OpcUaServer
    from drill_twin_rig.ros.rig import RigLink


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
        safe = Command(settings.safe_weight_on_bit, settings.safe_speed * math.tau)
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


class ControlDesk:
    """Decision on who commands: a client that requests control, the rig, or another node."""

    def __init__(self, node: TwinNode, output: CommandOutput, control: Control) -> None:
        """Begin without a client in control.

        Args:
            node: The gateway.
            output: Publisher of set-points.
            control: State of the control that clients request.
        """
        self._node, self.output, self.control = node, output, control
        self.rig: RigLink | None = None
        """Link to a rig, where there is one."""
        self.denied = ""
        """Reason why the last request was denied, in a sentence."""
        self._told: tuple[Permission, str] | None = None

    def work(self, server: OpcUaServer) -> None:
        """Decide what is due, show it to the clients, and repeat the set-points in force."""
        if self.control.check_heartbeat():
            self.output.go_safe()
            self._node.publish_diagnostics()
        if self.control.permission is Permission.PENDING and self._node.settings.grant != "ask":
            self._decide(granted=self._node.settings.grant == "always")
        held = self.output.is_safe or (self.rig is not None and self.rig.follows)
        if self.control.permission is Permission.UNSET and self.output.command is not None and not held:
            self.output.end()
        now = (self.control.permission, self.control.holder)
        if now != self._told:
            self._told = now
            server.show_control(*now)
        self.output.repeat()

    def _decide(self, *, granted: bool) -> str:
        """Grant or deny what is requested; returns the reason of a denial."""
        others = ", ".join(self.output.others())
        if self.rig is not None and self.rig.follows:
            others = "the rig"
        reason = f"{others} commands" if others else "" if granted else "the parameter grant is never"
        self.denied = f"control denied: {reason}" if reason else ""
        if reason:
            self.control.deny(reason)
        elif self.control.grant():
            self.output.begin()
            self._node.get_logger().info(f"{self.control.holder} has control")
        return reason

    def grant(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Answer `~/grant_control`: give control to the client that requests it."""
        del request
        pending = self.control.permission is Permission.PENDING
        response.message = self._decide(granted=True) if pending else "nobody requests control"
        response.success = not response.message
        return response

    def withdraw(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Answer `~/withdraw_control`: take control away; the last set-point holds until another source commands."""
        del request
        response.success = self.control.deny("withdrawn") or self.output.command is not None
        if self.rig is not None:
            self.rig.stop_following()
        self.output.end()
        self.denied = "control was withdrawn" if response.success else ""
        return response
