# SPDX-License-Identifier: Apache-2.0
"""OPC UA server of the gateway: the signals of the twin, with their D-WIS semantics, and set-points under control.

Without keys everybody on this host reads, unencrypted, and nobody writes. With keys clients need a trusted certificate,
Basic256Sha256 and a user with a password.
"""

import asyncio
import logging
import math
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from asyncua import Server, ua
from asyncua.common.callback import CallbackType

from drill_twin.core import __version__
from drill_twin.core.errors import RunError
from drill_twin.core.loopback import in_url
from drill_twin_rig.gateway.control import Control
from drill_twin_rig.gateway.opc_ua.address_space import AddressSpace
from drill_twin_rig.gateway.opc_ua.keys import PRIVATE_KEY, Keys
from drill_twin_rig.gateway.opc_ua.sessions import Sessions
from drill_twin_rig.gateway.rig_reader import EventLoopThread
from drill_twin_rig.gateway.signals import CommandTarget, ShownSignal

APPLICATION = "urn:drill_twin:gateway"
"""URI of the application, and of the namespace of its nodes."""
MOST_CLIENTS = 32
_PENDING = 10.0  # s that a connection may take to open a session
_FREE = 8  # places that are kept free of connections without a session
_LOOK = 0.1  # s between two looks at the places
logging.getLogger("asyncua").setLevel(logging.CRITICAL)  # what a client does wrong is no error of this program


START = 120.0
"""Longest wait until the server listens [s]: to build its nodes takes seconds, over 30 s under load; chosen."""


class OpcUaServer:
    """Server in a thread of its own."""

    def __init__(
        self,
        address: tuple[str, int],
        signals: Sequence[ShownSignal],
        targets: Sequence[CommandTarget],
        control: Control,
        keys: Keys | None,
    ) -> None:
        """Start to serve.

        Args:
            address: Address to listen on, and port.
            signals: Signals of the twin.
            targets: Set-points.
            control: Decides who writes them.
            keys: Keys; None: everybody reads, and nobody writes.

        Raises:
            RunError: The port is taken, the address is none of this machine, or the machine is too busy.
        """
        self.url = f"opc.tcp://{in_url(address[0])}:{address[1]}/drill_twin"
        """Address for clients."""
        self.sessions = Sessions(control, keys)
        """Users, and refused connections and writes."""
        self._targets, self._keys = targets, keys
        self._signals = {signal.name: signal for signal in signals}
        self._shown: dict[str, tuple[float, int]] = {}
        self._thread = EventLoopThread("opc_ua_server")
        try:
            self._thread.call(self._start(), START)
        except OSError as error:
            self._thread.close()
            if isinstance(error, TimeoutError):
                raise RunError(
                    f"{self.url} was not served within {START:g} s: the machine may be too busy; try again"
                ) from None
            raise RunError(
                f"expected a free port at {self.url}, found: {error.strerror}; set the parameter port"
            ) from None

    async def _start(self) -> None:
        server = Server(user_manager=self.sessions)
        await server.init()
        server.set_endpoint(self.url)
        server.set_server_name("drill_twin")
        server.iserver.max_connections = MOST_CLIENTS
        server.iserver.max_pending_activation_seconds = _PENDING
        await server.set_application_uri(APPLICATION)
        await server.set_build_info(APPLICATION, "drill_twin", "drill_twin", __version__, "0", datetime.now(UTC))
        await self._secure(server)
        space = AddressSpace()
        await space.begin(server, APPLICATION)
        self._nodes = {signal.name: await space.add_signal(signal) for signal in self._signals.values()}
        self._control_nodes = await space.add_control(self._targets)
        self.sessions.names = {node: name for name, node in self._control_nodes.items()}
        server.subscribe_server_callback(CallbackType.PreWrite, self.sessions.before_write)
        server.subscribe_server_callback(CallbackType.PostWrite, self.sessions.after_write)
        self._server = server
        await server.start()
        self._places = asyncio.get_running_loop().create_task(self._keep_places_free())

    async def _keep_places_free(self) -> None:
        """Close the oldest connections without a session while places are short; each would hold one for `_PENDING`."""
        while True:
            await asyncio.sleep(_LOOK)
            clients = list(self._server.bserver.clients)  # the oldest first
            sessions = [(one, one.processor.session) for one in clients]
            silent = [one for one, session in sessions if session is None or not session.is_activated()]
            for one in silent[: max(len(clients) - (MOST_CLIENTS - _FREE), 0)]:
                one.transport.close()
                self.sessions.refused["silent"] += 1

    async def _secure(self, server: Any) -> None:
        if self._keys is None:
            server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
            server.set_identity_tokens([ua.AnonymousIdentityToken])
            return
        await server.load_certificate(self._keys.certificate, "der")
        await server.load_private_key(self._keys.folder / PRIVATE_KEY)
        server.set_security_policy([ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt])
        server.set_identity_tokens([ua.UserNameIdentityToken])
        server.set_certificate_validator(self.sessions.check_certificate)

    def show(self, samples: Mapping[str, tuple[float, bool]], control: Mapping[str, int | str] | None = None) -> None:
        """Show values from now on; what has not changed is not sent again.

        Args:
            samples: Values of signals in their units, NaN where there is none, and whether their source is silent.
            control: Values of the nodes of control that the gateway writes.
        """
        now, changed = datetime.now(UTC), []
        for name, (value, is_stale) in samples.items():
            status = ua.StatusCodes.UncertainLastUsableValue if is_stale else ua.StatusCodes.Good
            status = status if math.isfinite(value) else ua.StatusCodes.BadNoData
            if (value, status) != self._shown.get(name):
                self._shown[name] = value, status
                variant = ua.Variant(value, ua.VariantType.Double)
                told = ua.DataValue(variant, ua.StatusCode(status), SourceTimestamp=now, ServerTimestamp=now)
                changed.append((self._nodes[name], told))
        for name, one in (control or {}).items():
            kind = ua.VariantType.String if isinstance(one, str) else ua.VariantType.UInt16
            changed.append((self._control_nodes[name], ua.DataValue(ua.Variant(one, kind))))
        if changed:
            self._thread.post(self._write(changed))

    async def _write(self, values: Sequence[tuple[Any, Any]]) -> None:
        """Write values by node id."""
        for node, value in values:
            await self._server.write_attribute_value(node, value)

    @property
    def clients(self) -> int:
        """Number of connected clients."""
        return len(self._server.bserver.clients)

    def close(self) -> None:
        """End all sessions, and the thread."""
        self._thread.call(self._server.stop())
        self._thread.close()
