# SPDX-License-Identifier: Apache-2.0
"""Gateway node: shows the twin to rig software by OPC UA.

The OPC UA server runs in a thread of its own. This node takes messages some tens of times a second instead of waiting
for each, which would cost more than all the rest.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from rclpy.context import Context

from drill_twin.errors import DrillTwinError, MessageError
from drill_twin.gateway.quantities import QUANTITIES, TwinQuantities
from drill_twin.gateway.signals import read_signals, signals_path
from drill_twin.io.messages.diagnostics import Level, Status
from drill_twin.io.messages.topics import TOPICS
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.pacing import Tick
from drill_twin.ros.core.parameters import Value
from drill_twin.ros.gateway.parameters import PARAMETERS

if TYPE_CHECKING:
    from drill_twin.gateway.server import OpcUaServer, Sample

_TURN = 0.02  # s between two turns of the loop
_DEPTH = 100  # messages; half a second at 200 Hz


class Gateway(TwinNode):
    """Shows the quantities of the twin on an OPC UA server."""

    NAME: ClassVar = "gateway"
    PURPOSE: ClassVar = "Shows the twin to rig software by OPC UA, with the signals of D-WIS. Needs asyncua."
    PARAMETERS: ClassVar = PARAMETERS

    def __init__(
        self, context: Context, values: Mapping[str, Value] | None = None, other_parameters: Sequence[str] = ()
    ) -> None:
        super().__init__(context, values, other_parameters)
        self._signals = read_signals(signals_path(self.settings.signals))
        self._quantities = TwinQuantities(time.monotonic)
        self._due = Tick(1.0 / self.settings.rate)
        self._unread = ""
        self._server: OpcUaServer | None = None

    def open(self) -> None:
        """Start the server, and subscribe to the topics of its signals."""
        self._server = _make_server(self.settings.host, self.settings.port, self._signals.show)
        for topic in {QUANTITIES[signal.quantity].topic for signal in self._signals.show}:
            latched = TOPICS[topic].latched
            self.topics.subscribe(topic, partial(self._on_message, topic), depth=1 if latched else _DEPTH)
        self.get_logger().info(f"{len(self._signals.show)} signals at {self._server.url}")

    def _on_message(self, topic: str, raw: bytes, info: Mapping[str, Any]) -> None:
        del info
        try:
            self._quantities.take(topic, bytes(raw))
        except MessageError as error:
            self._unread = f"{topic}: {error}"

    def work(self) -> None:
        """Take messages, and show the values once they are due."""
        time.sleep(_TURN)
        self.spin_once(0.0)
        if self._server is not None and self._due.due():
            self._server.show(self._samples())

    def _samples(self) -> dict[str, Sample]:
        from drill_twin.gateway.server import Sample

        values, samples = self._quantities.values, {}
        for signal in self._signals.show:
            if signal.quantity in values:
                value = values[signal.quantity] / signal.factor
                samples[signal.name] = Sample(value, self._is_stale(signal.quantity))
        return samples

    def _is_stale(self, quantity: str) -> bool:
        if QUANTITIES[quantity].on_change:
            return False
        slow = TOPICS[QUANTITIES[quantity].topic].rate == "1 Hz"
        return self._quantities.age(quantity) > float(self.settings.stale_after) + slow

    def close(self) -> None:
        """End the server."""
        if self._server is not None:
            self._server.close()

    def health(self) -> Status:
        """Clients, and the signals that have no value or an old one."""
        absent = [one.name for one in self._signals.show if one.quantity not in self._quantities.values]
        stale = [
            one.name
            for one in self._signals.show
            if one.quantity in self._quantities.values and self._is_stale(one.quantity)
        ]
        values = {
            "url": self._server.url if self._server else "",
            "clients": str(self._server.clients if self._server else 0),
            "signals": str(len(self._signals.show)),
            "without_value": " ".join(absent),
            "stale": " ".join(stale),
        }
        if self._unread:
            text, self._unread = f"a message could not be read: {self._unread}", ""
            return Status(self.NAME, Level.WARN, text, values)
        if stale:
            return Status(
                self.NAME, Level.WARN, f"the twin is silent: {len(stale)} signals are marked uncertain", values
            )
        text = "waiting for the twin" if len(absent) == len(self._signals.show) else "showing the twin"
        return Status(self.NAME, Level.OK, text, values)


def _make_server(*arguments: Any) -> OpcUaServer:
    """Start the server.

    Raises:
        DrillTwinError: asyncua is not installed.
        RunError: The port is taken.
    """
    try:
        from drill_twin.gateway.server import OpcUaServer
    except ModuleNotFoundError as error:
        raise DrillTwinError(
            f"expected the Python module {error.name!r}, found none; pip install 'drill_twin[opcua]'"
        ) from error
    return OpcUaServer(*arguments)
