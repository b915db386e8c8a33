# SPDX-License-Identifier: Apache-2.0
"""OPC UA client of the gateway: reads the signals of a rig's server, and connects again by itself.

All nodes are read in one request a period. A subscription would be silent for a value that does not change, which could
not be told from a server that has stopped.
"""

import asyncio
import math
from collections.abc import Sequence
from datetime import UTC
from typing import Any, NamedTuple

from asyncua import Client, ua
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256

from drill_twin_rig.gateway.opc_ua.keys import CERTIFICATE, Keys
from drill_twin_rig.gateway.rig_reader import PATIENCE, RefusedError, RigReader, SignalReading, unit_fault
from drill_twin_rig.gateway.signals import RigSignal


class ServerAccess(NamedTuple):
    """Address of a rig's server, and the way to enter it."""

    url: str
    """Address, as `opc.tcp://rig:4840`."""
    keys: Keys | None = None
    """Keys for an encrypted connection; None for an open one."""
    application: str = ""
    """URI of this application, as in its certificate."""
    user: str = ""
    """User; empty: anonymous."""
    password: str = ""
    """His password."""


class RigClient(RigReader):
    """Client of the OPC UA server of a rig."""

    def __init__(self, access: ServerAccess, signals: Sequence[RigSignal], period: float) -> None:
        """Begin to read.

        Args:
            access: Server of the rig.
            signals: Signals to read.
            period: Time between two readings [s].
        """
        self._access = access
        super().__init__(signals, period)

    async def connect_and_read(self) -> None:
        """Connect, and read all nodes once a period until it fails.

        Raises:
            RefusedError: The server is not to be used.
        """
        client = Client(self._access.url, timeout=PATIENCE)
        if self._access.keys is not None:
            await self._secure(client, self._access.keys)
        if self._access.user:
            client.set_user(self._access.user)
            client.set_password(self._access.password)
        async with client:
            uris = await client.get_namespace_array()
            nodes = [client.get_node(_node_id(signal.node, uris)) for signal in self._signals]
            self._unusable = [
                unit_fault(signal, await _unit(node)) for signal, node in zip(self._signals, nodes, strict=True)
            ]
            self._connected()
            ids = [node.nodeid for node in nodes]
            while True:
                self._take(map(_reading, await client.uaclient.read_attributes(ids, ua.AttributeIds.Value)))
                await asyncio.sleep(self._period)

    async def _secure(self, client: Any, keys: Keys) -> None:
        """Use the server's encrypted endpoint, if its certificate is trusted.

        Raises:
            RefusedError: The server has no encrypted endpoint, or the certificate is not trusted.
        """
        uri, encrypted = SecurityPolicyBasic256Sha256.URI, ua.MessageSecurityMode.SignAndEncrypt
        offered = await client.connect_and_get_server_endpoints()
        found = [one for one in offered if one.SecurityPolicyUri == uri and one.SecurityMode == encrypted]
        if not found:
            raise RefusedError(
                "expected Basic256Sha256 with encryption of the server of the rig, found no such endpoint"
            )
        if reason := keys.distrust(bytes(found[0].ServerCertificate)):
            raise RefusedError(f"server of the rig: {reason}")
        client.application_uri = self._access.application
        await client.set_security(
            SecurityPolicyBasic256Sha256,
            str(keys.folder / CERTIFICATE),
            str(keys.private_key),
            server_certificate=bytes(found[0].ServerCertificate),
        )


def _reading(found: Any) -> SignalReading:
    stamp = found.SourceTimestamp
    if stamp is not None and stamp.tzinfo is None:
        stamp = stamp.replace(tzinfo=UTC)
    status = "" if found.StatusCode is None or found.StatusCode.is_good() else found.StatusCode.name
    value = found.Value.Value if found.Value is not None else None
    return SignalReading(value, status, stamp.timestamp() if stamp is not None else math.nan)


def _node_id(text: str, uris: Sequence[str]) -> Any:
    """Node id of a text.

    Raises:
        RefusedError: The text is no node id, or the server has no such namespace.
    """
    try:
        if text.startswith("nsu="):
            uri, _, rest = text.removeprefix("nsu=").partition(";")
            if uri not in uris:
                raise RefusedError(f"expected the namespace {uri} on the server of the rig, found none of that name")
            text = f"ns={uris.index(uri)};{rest}"
        return ua.NodeId.from_string(text)
    except ua.UaError as error:
        raise RefusedError(f'expected a node id such as "ns=2;s=WOB", found "{text}"') from error


async def _unit(node: Any) -> str:
    """Text of the unit that the server gives to a node; empty without one."""
    try:
        information = await (await node.get_child("0:EngineeringUnits")).read_value()
        return str(information.DisplayName.Text or "")
    except (ua.UaError, AttributeError):
        return ""
