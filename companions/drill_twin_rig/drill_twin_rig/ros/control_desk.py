# SPDX-License-Identifier: Apache-2.0
"""Decision on who commands at the gateway: a client that requests control, the rig, or another node."""

from __future__ import annotations

from typing import TYPE_CHECKING

from std_srvs.srv import Trigger

from drill_twin.ros.core.node import TwinNode
from drill_twin_rig.gateway.control import Control, Permission
from drill_twin_rig.ros.commands import CommandOutput
from drill_twin_rig.ros.rig import RigLink

if TYPE_CHECKING:
    from drill_twin_rig.gateway.opc_ua.server import OpcUaServer


class ControlDesk:
    """Decides who commands: a client that requests control, the rig, or another node."""

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
