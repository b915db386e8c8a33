# SPDX-License-Identifier: Apache-2.0
"""Gateway node: shows the twin to rig software by OPC UA, and takes set-points of a client that has control.

The OPC UA server runs in a thread of its own; a target that a client writes is published from there. This node takes
messages some tens of times a second instead of waiting for each, which would cost more than all the rest.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from std_srvs.srv import Trigger

from drill_twin.core.errors import MessageError, ParameterError, missing
from drill_twin.core.loopback import is_loopback
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.topics import ADVICE_MAP, DIAGNOSTICS, RIG_STATE, TOPICS, TWIN_SCENE, WHIRL_ONSET
from drill_twin.ros.core.diagnostics_publisher import hardware_id
from drill_twin.ros.core.node import AUTOSTART, TwinNode
from drill_twin.ros.core.parameters import Parameter
from drill_twin.ros.core.policy import Rights
from drill_twin_rig.gateway.control import Control, Permission
from drill_twin_rig.gateway.quantities import QUANTITIES, TwinQuantities
from drill_twin_rig.gateway.signals import SET_POINTS, Limits, Signals, read_signals, signals_path
from drill_twin_rig.ros.commands import CommandOutput
from drill_twin_rig.ros.rig import ControlDesk, RigLink

if TYPE_CHECKING:
    from drill_twin_rig.gateway.opc_ua.keys import Keys
    from drill_twin_rig.gateway.opc_ua.server import OpcUaServer

_TURN = 0.05  # s between two turns of the loop
_CONTROL_PERIOD = 0.1  # s
_DEPTH = 100  # messages; half a second at 200 Hz


class Gateway(TwinNode):
    """Shows the quantities of the twin on an OPC UA server, and commands it for a client."""

    NAME = "gateway"
    PURPOSE = "Connects the twin with rig software by OPC UA, with the signals of D-WIS. Needs asyncua."
    PARAMETERS = (
        Parameter("signals", "dwis", "file with a line a signal: an installed one by name, or a path"),
        Parameter("host", "127.0.0.1", "address of the OPC UA server; 0.0.0.0: all of this machine"),
        Parameter("port", 4840, "port of the OPC UA server", "", 1, 65535),
        Parameter("rate", 10.0, "values a second on the OPC UA server", "Hz", 0.1, 50.0),
        Parameter(
            "keys",
            "",
            "folder of keys (drill-twin ros keys): clients need a trusted certificate, encryption and a user; "
            '"": everybody reads without encryption, on this host only, and nobody commands',
        ),
        Parameter(
            "grant",
            "ask",
            "control that a client requests: ask: granted by ~/grant_control; always: granted at once; never: denied",
            choices=("ask", "always", "never"),
            live=True,
        ),
        Parameter(
            "heartbeat_timeout", 2.0, "wall time without a heartbeat after which control is lost", "s", 0.2, 60.0
        ),
        Parameter(
            "rig_url",
            "",
            "server of a rig (OPC UA, or WITS level 0 as wits://rig:5001), whose signals of the sections measure and "
            'follow are read; "": none',
            such_as="opc.tcp://rig:4840",
        ),
        Parameter(
            "rig_security",
            "sign_and_encrypt",
            "connection: sign_and_encrypt: with keys, Basic256Sha256; none: open, and set-points are followed "
            "on this host only",
            choices=("sign_and_encrypt", "none"),
        ),
        Parameter(
            "rig_user",
            "",
            'user on the rig; password: in the file rig_password in keys; "": anonymous',
        ),
        Parameter("rig_rate", 10.0, "readings of the rig a second", "Hz", 0.1, 50.0),
        AUTOSTART,
    )
    RIGHTS = Rights(
        (DIAGNOSTICS, TWIN_SCENE, *{quantity.topic for quantity in QUANTITIES.values()}),
        ("~/grant_control", "~/withdraw_control"),
    )

    ON_CHANGE = (WHIRL_ONSET, ADVICE_MAP, TWIN_SCENE)
    TIMED_BY = RIG_STATE

    _server: OpcUaServer
    """Server; made by `configure`."""

    def configure(self) -> None:
        """Start server and client; create subscriptions to the topics of the signals, services and timers."""
        if not self.settings.keys and not is_loopback(self.settings.host):
            raise ParameterError(
                f"parameter host: expected an address of this host only, as keys is not set, found "
                f"{self.settings.host}; make keys with drill-twin ros keys"
            )
        self._signals = read_signals(signals_path(self.settings.signals))
        self._quantities = TwinQuantities(self.samples)
        self._output = CommandOutput(self, self._quantities)
        self._limits: Limits = {}
        self._refused_before = 0
        self._control = Control(
            self._signals.command,
            self.settings.heartbeat_timeout,
            lambda: self._output.send(self._control.values),  # at once, in the server's thread
            self._limits,
        )
        self._desk = ControlDesk(self, self._output, self._control)
        self._unread = ""
        self._server, keys = _make_server(self.settings, self._signals, self._control)
        if self.settings.rig_url:
            self._desk.rig = RigLink(self, self._output, self._signals, keys, self._limits)
        topics = {QUANTITIES[signal.quantity].topic for signal in self._signals.show}
        topics |= {RIG_STATE} if self._signals.command or self._desk.rig else set()
        for topic in topics:
            depth = 1 if TOPICS[topic].latched else _DEPTH
            self.topics.subscribe_raw(topic, partial(self._on_message, topic), depth=depth)
        self.samples.expect(*sorted(topics))
        self.topics.subscribe(DIAGNOSTICS, self._on_diagnostics, malformed=self._on_unreadable)
        self.topics.subscribe_scenes(self._on_scene)
        self.create_service(Trigger, "~/grant_control", self._desk.grant)
        self.create_service(Trigger, "~/withdraw_control", self._desk.withdraw)
        self.every(1.0 / self.settings.rate, lambda: self._server.show(self._samples()))
        self.every(_CONTROL_PERIOD, lambda: self._desk.work(self._server))
        policy = f"Basic256Sha256, keys in {keys.folder}" if keys else "None, read only"
        self.get_logger().info(f"{len(self._signals.show)} signals at {self._server.url}; security policy {policy}")

    def deactivate(self) -> None:
        """Command nothing while at rest."""
        self._control.deny("the gateway was deactivated")
        if self._desk.rig is not None:
            self._desk.rig.stop_following()
        self._output.end()

    def complete(self) -> None:
        """End server and client."""
        if hasattr(self, "_server"):
            if self._desk.rig is not None:
                self._desk.rig.client.close()
            self._server.close()

    def _on_message(self, topic: str, raw: bytes, _: Mapping[str, Any]) -> None:
        try:
            self._quantities.take(topic, raw)
        except MessageError as error:
            self._unread = f"{topic}: {error}"

    def _on_unreadable(self, reason: str) -> None:
        self._unread = f"{DIAGNOSTICS}: {reason}"

    def _on_scene(self, _: bytes) -> None:
        self._quantities.stamp = 0  # time may have gone back; without a stamp a command is of its time of arrival

    def _on_diagnostics(self, found: tuple[int, Sequence[Status]]) -> None:
        """Take what the simulator of this twin tells: its limits, which may change, and what it refused."""
        told = (one.values for one in found[1] if one.hardware_id == hardware_id(self))
        for values in (one for one in told if "range_weight_on_bit" in one):
            try:
                for quantity in SET_POINTS:
                    low, high = map(float, values[f"range_{quantity}"].split())
                    self._limits[quantity] = low, high
                refused = int(values["commands_refused"])
                if values.get("commander") == self.get_fully_qualified_name():  # the commands of others were refused
                    refused -= int(values.get("commands_refused_other_source", 0))
            except (KeyError, ValueError) as error:
                raise MessageError(f"expected limits in the diagnostics of the simulator, found {error}") from error
            refuses = self._output.command is not None and refused > self._refused_before
            self._desk.twin_refuses = values.get("last_refusal", "") if refuses else ""
            self._refused_before = refused

    def step(self) -> None:
        """Process many messages at a time."""
        time.sleep(_TURN)
        self.spin_all()

    # --- twin -> OPC UA -------------------------------------------------------------------------------------------

    def _samples(self) -> dict[str, tuple[float, bool]]:
        """Value of each signal in its unit, where it has one, and whether its source is silent."""
        values, samples, found = self._quantities.values, self.samples, {}
        for signal in self._signals.show:
            if signal.quantity in values:
                topic = QUANTITIES[signal.quantity].topic
                is_stale = not (TOPICS[topic].latched or samples.rests) and samples.age(topic) > samples.patience(topic)
                found[signal.name] = values[signal.quantity] / signal.factor, is_stale
        return found

    def health(self) -> Status:
        """Clients, control, and the signals that have no value or an old one."""
        present = self._samples()
        stale = [name for name, (_, is_stale) in present.items() if is_stale]
        server, command = self._server, self._output.command
        values = {
            "url": server.url,
            "clients": str(server.clients),
            "signals": str(len(self._signals.show)),
            "without_value": " ".join(one.name for one in self._signals.show if one.name not in present),
            "stale": " ".join(stale),
            "permission": self._control.permission.name.lower(),
            "holder": self._control.holder,
            "commands_sent": str(self._output.sent),
            **{f"refused_{kind}": str(count) for kind, count in server.sessions.refused.items()},
            **self.samples.values(),
        }
        if command is not None:
            values |= {"weight_on_bit": f"{command.weight_on_bit:g}", "speed_rev_s": f"{command.rotation / math.tau:g}"}
        if self._desk.rig is not None:
            values |= self._desk.rig.values()
        unread = f"a message could not be read: {self._unread}" if self._unread else ""
        shows = Level.OK, "showing the twin" if present else "waiting for the twin"
        told = self.status(values, *self._faults(), (Level.WARN, unread), self._silence(stale), shows)
        self._unread = "" if told.text == unread else self._unread
        return told

    def _faults(self) -> Iterator[tuple[Level, str]]:
        """Levels and sentences on rig, control and clients, the worst first; empty ones where all is well."""
        control, refusal = self._control, self._server.sessions.refusal
        lost = (self._desk.rig is not None and self._desk.rig.lost) or (
            control.lost if control.permission is Permission.INVALID else ""
        )
        if self._output.command is None and not self._output.others():
            yield Level.ERROR, lost and f"control lost: {lost}; the simulator does what its on_silence says"
        if self._desk.rig is not None:
            yield Level.WARN, self._desk.rig.fault()
        if control.permission is Permission.PENDING and control.user is not None:
            yield Level.WARN, f"{control.user.name} requests control: call ~/grant_control"
        yield Level.WARN, refusal and f"refused: {refusal}"
        yield Level.WARN, self._desk.denied if control.permission is Permission.DENIED else ""
        refused = self._desk.twin_refuses
        yield Level.WARN, refused and f"the twin refuses the set-point: {refused}"

    def _silence(self, stale: Sequence[str]) -> tuple[Level, str]:
        """Level, and a sentence on signals without a value of late; empty where there is none."""
        level, text = self.samples.verdict()
        if not stale and level is Level.OK:
            return Level.OK, ""
        silent = "the twin is silent" if level in {Level.OK, Level.STALE} else ""
        said = filter(None, (silent, text, f"{len(stale)} signals are marked uncertain" if stale else ""))
        return max(level, Level.WARN), ": ".join(said)


def _make_server(settings: Any, signals: Signals, control: Control) -> tuple[OpcUaServer, Keys | None]:
    """Start the server, with the keys of its folder if one is named.

    Raises:
        DrillTwinError: asyncua is not installed, or the keys cannot be used.
        RunError: The port is taken.
    """
    try:
        from drill_twin_rig.gateway.opc_ua.keys import read_keys
        from drill_twin_rig.gateway.opc_ua.server import OpcUaServer
    except ModuleNotFoundError as error:
        raise missing(error, "opcua") from error
    keys = read_keys(Path(settings.keys)) if settings.keys else None
    return OpcUaServer((settings.host, settings.port), signals.show, signals.command, control, keys), keys
