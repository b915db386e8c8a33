# SPDX-License-Identifier: Apache-2.0
"""Signals of a rig as topics, its set-points as commands, and the decision who commands."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import numpy as np
from std_srvs.srv import Trigger

from drill_twin.core.errors import ParameterError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.loopback import is_loopback
from drill_twin.core.rig_channels import ARRAYS, RIG_JOINTS
from drill_twin.dynamics.sensors.subs import SUMMARY
from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.messages.topics import MEASURED as MEASURED_NAMESPACE
from drill_twin.io.messages.topics import MEASURED_RIG_STATE, summary_topic
from drill_twin.ros.core.node import TwinNode
from drill_twin_rig.gateway.control import HOLDER, PERMISSION, REFUSAL, Control, Permission
from drill_twin_rig.gateway.quantities import MEASURED, downhole
from drill_twin_rig.gateway.rig_reader import RigReader
from drill_twin_rig.gateway.signals import Limits, RigSignal, Signals, why_refused
from drill_twin_rig.gateway.wits0 import WitsReader
from drill_twin_rig.ros.commands import CommandOutput

if TYPE_CHECKING:
    from drill_twin_rig.gateway.opc_ua.keys import Keys
    from drill_twin_rig.gateway.opc_ua.server import OpcUaServer
    from drill_twin_rig.gateway.rig_reader import CheckedValue


class RigLink:
    """Link to a rig: publishes what it measures, and sends its set-points."""

    def __init__(
        self, node: TwinNode, output: CommandOutput, signals: Signals, keys: Keys | None, limits: Limits
    ) -> None:
        """Begin to read.

        Args:
            node: The gateway.
            output: Publisher of set-points.
            signals: Signals of the file.
            keys: Keys of the gateway.
            limits: Limits of the simulator, as they are known at a time.

        Raises:
            ParameterError: The connection would not be secure enough for what is asked of it.
        """
        settings, read = node.settings, (*signals.measure, *signals.follow)
        wits, secure = _is_wits(settings), _is_secure(settings)
        check_security(settings, follows=bool(signals.follow), has_keys=keys is not None)
        self._node, self._output, self._signals, self._limits = node, output, signals, limits
        self.client: RigReader = (
            WitsReader(settings.rig_url, read) if wits else _opc_ua_client(settings, read, keys if secure else None)
        )
        """Reader of the rig."""
        self._checked = self.client.checked()
        self._published, self._withdrawn = dict[str, int](), False
        measured = {MEASURED[one.quantity][0] for one in signals.measure if one.quantity in MEASURED}
        self._joints = tuple(joint for joint in RIG_JOINTS if joint in measured)
        self._template = JointStateTemplate(self._joints)
        node.topics.advertise(MEASURED_RIG_STATE)
        subs = dict.fromkeys(downhole(one.quantity)[0] for one in signals.measure if all(downhole(one.quantity)))
        self._summaries = {sub: JointStateTemplate(SUMMARY, velocity=False, effort=False, frame_id=sub) for sub in subs}
        for sub in subs:
            node.topics.advertise(MEASURED_NAMESPACE + summary_topic(sub))
        self.follows = False
        """True while the set-points of the rig are in force."""
        self.lost = ""
        """Reason why the set-points of the rig are not in force any more; empty before, and once they are again."""

    def work(self) -> None:
        """Publish what has come, and send the set-points while they are sound."""
        self._checked = self.client.checked()
        self._publish()
        if self._signals.follow and not self._withdrawn:
            self._follow()

    def _publish(self) -> None:
        """Publish the values of the surface and of each sub, where one is newer than all that were published."""
        sound = {one.quantity: self._checked[one] for one in self._signals.measure if not self._checked[one].fault}
        surface = {MEASURED[quantity]: checked for quantity, checked in sound.items() if quantity in MEASURED}
        if stamp := self._newer(MEASURED_RIG_STATE, surface.values()):
            values = np.full((len(ARRAYS), len(self._joints)), np.nan)
            for (joint, array), checked in surface.items():
                values[ARRAYS.index(array), self._joints.index(joint)] = checked.value
            self._node.topics.publish(MEASURED_RIG_STATE, self._template.fill(stamp, *values))
        for sub, template in self._summaries.items():
            found = {name: sound[f"{sub}.{name}"] for name in SUMMARY if f"{sub}.{name}" in sound}
            topic = MEASURED_NAMESPACE + summary_topic(sub)
            if stamp := self._newer(topic, found.values()):
                row = [found[name].value if name in found else math.nan for name in SUMMARY]
                self._node.topics.publish(topic, template.fill(stamp, row))

    def _newer(self, topic: str, sound: Collection[CheckedValue]) -> int:
        """Stamp of the newest value [ns]; 0 unless it is newer than the last stamp on the topic."""
        stamp = max((stamp_ns(one.stamp) for one in sound if math.isfinite(one.stamp)), default=0)
        if stamp <= self._published.get(topic, 0):
            return 0
        self._published[topic] = stamp
        return stamp

    def _follow(self) -> None:
        fault = self._fault_of(self._signals.follow) or self._beyond_limits()
        if not fault and (self.follows or (self._output.command is None and not self._output.others())):
            if not self.follows:
                self._output.begin()
            self.follows, self.lost = True, ""
            self._output.send({one.quantity: self._checked[one].value for one in self._signals.follow})
        elif fault and self.follows:
            self.follows, self.lost = False, fault
            self._output.end()
            self._node.publish_diagnostics()

    def stop_following(self) -> None:
        """Leave the set-points of the rig alone from now on."""
        self._withdrawn, self.follows, self.lost = True, False, ""

    def _fault_of(self, signals: Sequence[RigSignal]) -> str:
        """First fault of some signals, with its quantity; empty if all are sound."""
        found = ((one, self._checked[one]) for one in signals)
        return next((f"{one.quantity} of the rig: {checked.fault}" for one, checked in found if checked.fault), "")

    def _beyond_limits(self) -> str:
        """First set-point of the rig that the simulator does not admit, in a sentence; empty if all are admitted."""
        for one in self._signals.follow:
            if reason := why_refused(one, self._checked[one].value / one.factor, self._limits):
                return f"{one.quantity} of the rig: {reason}"
        return ""

    def fault(self) -> str:
        """First fault of all, as a sentence; empty if all is sound."""
        if self.client.fault:
            return f"no connection to the rig: {self.client.fault}"
        return self._fault_of((*self._signals.measure, *self._signals.follow)) or self._beyond_limits()

    def values(self) -> dict[str, str]:
        """Values for the diagnostics."""
        return {
            "rig_connections": str(self.client.connections),
            "rig_follows": str(self.follows).lower(),
            **{
                f"measured_{one.quantity}": found.fault or f"{found.value:g}"
                for one in self._signals.measure
                for found in [self._checked[one]]
            },
            **{f"left_out_{quantity}": text for quantity, text in self.client.left_out().items() if text},
        }


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
        self.twin_refuses = ""
        """Reason why the twin refuses the set-point in force, as its diagnostics tell it; empty if it does not."""
        self._told: Mapping[str, int | str] = {}

    def work(self, server: OpcUaServer) -> None:
        """Decide what is due, show it to the clients, repeat the set-points in force, and do the work of the link."""
        if self.control.check_heartbeat():
            self.output.end()
            self._node.publish_diagnostics()
        if self.control.permission is Permission.PENDING and self._node.settings.grant != "ask":
            self._decide(granted=self._node.settings.grant == "always")
        held = self.rig is not None and self.rig.follows
        if self.control.permission is not Permission.GRANTED and self.output.command is not None and not held:
            self.output.end()
        now: dict[str, int | str] = {
            PERMISSION: self.control.permission,
            HOLDER: self.control.holder,
            REFUSAL: self.twin_refuses,
        }
        if now != self._told:
            self._told = now
            server.show({}, now)
        self.output.send({})
        if self.rig is not None:
            self.rig.work()

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

    def grant(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Answer `~/grant_control`: give control to the client that requests it."""
        pending = self.control.permission is Permission.PENDING
        response.message = self._decide(granted=True) if pending else "nobody requests control"
        response.success = not response.message
        return response

    def withdraw(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Answer `~/withdraw_control`: take control away; the simulator does what its `on_silence` says."""
        response.success = self.control.deny("withdrawn") or self.output.command is not None
        if self.rig is not None:
            self.rig.stop_following()
        self.output.end()
        self.denied = "control was withdrawn" if response.success else ""
        return response


def _is_wits(settings: Any) -> bool:
    return bool(urlsplit(settings.rig_url).scheme == "wits")


def _is_secure(settings: Any) -> bool:
    return bool(settings.rig_security == "sign_and_encrypt") and not _is_wits(settings)


def check_security(settings: Any, *, follows: bool, has_keys: bool) -> None:
    """Refuse a connection to a rig that is not secure enough for what is asked of it.

    Raises:
        ParameterError: Keys are missing, or set-points or a password would cross the network in clear.
    """
    if _is_secure(settings):
        if not has_keys:
            raise ParameterError(
                "parameter keys: expected a folder of drill-twin ros keys for sign_and_encrypt, found none"
            )
    elif not is_loopback(urlsplit(settings.rig_url).hostname or ""):
        for reason, holds in (
            ("set-points of another host are followed", follows),
            ("the password of rig_user goes to another host", bool(settings.rig_user)),
        ):
            if holds:
                raise ParameterError(
                    f"parameter rig_security: expected sign_and_encrypt, as {reason}; WITS has no encryption"
                )


def _opc_ua_client(settings: Any, signals: Sequence[RigSignal], keys: Keys | None) -> RigReader:
    from drill_twin_rig.gateway.opc_ua.keys import check_private
    from drill_twin_rig.gateway.opc_ua.rig_client import RigClient

    password = ""
    if settings.rig_user:
        file = Path(settings.keys) / "rig_password"
        password = ForeignFile("a file with the password of rig_user", 10_000, ParameterError).text(file).strip()
        check_private(file)
    return RigClient(settings, signals, keys, password)
