# SPDX-License-Identifier: Apache-2.0
"""OPC UA server of the gateway: the signals of the twin, with their D-WIS semantics."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from asyncua import Server, ua
from asyncua.crypto.permission_rules import UserRole

from drill_twin import __version__
from drill_twin.errors import RunError
from drill_twin.gateway.address_space import AddressSpace
from drill_twin.gateway.event_loop import EventLoopThread
from drill_twin.gateway.signals import Shown

APPLICATION = "urn:drill_twin:gateway"
"""URI of the application, and of the namespace of its nodes."""
MOST_CLIENTS = 32
_PENDING = 10.0  # s that a connection may take to open a session
logging.getLogger("asyncua").setLevel(logging.CRITICAL)  # what a client does wrong is no error of this program


@dataclass(frozen=True)
class Sample:
    """Value of a signal in its unit."""

    value: float
    """Value; NaN where there is none."""
    stale: bool = False
    """True if it is an old one, whose source is silent."""


@dataclass(frozen=True)
class User:
    """User of a session."""

    name: str = ""
    """Name; empty for an anonymous one."""
    role: UserRole = UserRole.User
    """Role in the library: reading, and writing where a node admits it."""


class _Anonymous:
    """Admits everybody to read."""

    @staticmethod
    def get_user(*_: Any, **__: Any) -> User:
        return User()


class OpcUaServer:
    """Server in a thread of its own."""

    def __init__(self, host: str, port: int, signals: Sequence[Shown]) -> None:
        """Start to serve.

        Args:
            host: Address to listen on.
            port: Port.
            signals: Signals of the twin.

        Raises:
            RunError: The port is taken, or the address is none of this machine.
        """
        self.url = f"opc.tcp://{host}:{port}/drill_twin"
        """Address for clients."""
        self._signals = {signal.name: signal for signal in signals}
        self._shown: dict[str, tuple[float, int]] = {}
        self._thread = EventLoopThread("opc_ua_server")
        try:
            self._thread.call(self._start())
        except OSError as error:
            self._thread.close()
            raise RunError(
                f"expected a free port at {self.url}, found: {error.strerror}; set the parameter port"
            ) from None

    async def _start(self) -> None:
        server = Server(user_manager=_Anonymous())
        await server.init()
        server.set_endpoint(self.url)
        server.set_server_name("drill_twin")
        server.iserver.max_connections = MOST_CLIENTS
        server.iserver.max_pending_activation_seconds = _PENDING
        await server.set_application_uri(APPLICATION)
        await server.set_build_info(APPLICATION, "drill_twin", "drill_twin", __version__, "0", datetime.now(UTC))
        server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        server.set_identity_tokens([ua.AnonymousIdentityToken])
        space = await AddressSpace.build(server, APPLICATION)
        self._nodes = {signal.name: await space.add_signal(signal) for signal in self._signals.values()}
        self._server = server
        await server.start()

    def show(self, samples: Mapping[str, Sample]) -> None:
        """Show the values of signals from now on; what has not changed is not sent again."""
        changed = []
        for name, sample in samples.items():
            value = (sample.value, _status(sample))
            if value != self._shown.get(name):
                self._shown[name] = value
                changed.append((name, *value))
        if changed:
            self._thread.post(self._write(changed))

    async def _write(self, changed: Sequence[tuple[str, float, int]]) -> None:
        now = datetime.now(UTC)
        for name, value, status in changed:
            data = ua.DataValue(
                ua.Variant(value, ua.VariantType.Double),
                ua.StatusCode(status),
                SourceTimestamp=now,
                ServerTimestamp=now,
            )
            await self._server.write_attribute_value(self._nodes[name], data)

    @property
    def clients(self) -> int:
        """Number of connected clients."""
        return len(self._server.bserver.clients)

    def close(self) -> None:
        """End all sessions, and the thread."""
        self._thread.call(self._server.stop())
        self._thread.close()


def _status(sample: Sample) -> int:
    if not math.isfinite(sample.value):
        return int(ua.StatusCodes.BadNoData)
    return int(ua.StatusCodes.UncertainLastUsableValue if sample.stale else ua.StatusCodes.Good)
