# SPDX-License-Identifier: Apache-2.0
"""OPC UA client of the gateway: reads the signals of a rig's server, and connects again by itself.

All nodes are read in one request a period. A subscription would be silent for a value that does not change, which could
not be told from a server that has stopped.
"""

import asyncio
import math
from collections.abc import Sequence
from datetime import UTC
from types import SimpleNamespace
from typing import Any

from asyncua import Client, ua
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256

from drill_twin_rig.gateway.opc_ua.keys import CERTIFICATE, PRIVATE_KEY, Keys
from drill_twin_rig.gateway.opc_ua.server import APPLICATION
from drill_twin_rig.gateway.rig_reader import PATIENCE, RefusedError, RigReader, SignalReading, unit_fault
from drill_twin_rig.gateway.signals import RigSignal


class RigClient(RigReader):
    """Client of the OPC UA server of a rig."""

    def __init__(
        self, settings: SimpleNamespace, signals: Sequence[RigSignal], keys: Keys | None, password: str
    ) -> None:
        """Begin to read.

        Args:
            settings: Parameters `rig_url`, as `opc.tcp://rig:4840`, `rig_user` and `rig_rate` of the gateway.
            signals: Signals to read.
            keys: Keys for an encrypted connection; None for an open one.
            password: Password of the user.
        """
        self._settings, self._keys, self._password = settings, keys, password
        super().__init__(signals, 1.0 / settings.rig_rate)

    async def connect_and_read(self) -> None:
        """Connect, and read all nodes once a period until it fails.

        Raises:
            RefusedError: The server is not to be used.
        """
        client = Client(self._settings.rig_url, timeout=PATIENCE)
        if self._keys is not None:
            await self._secure(client, self._keys)
        if self._settings.rig_user:
            client.set_user(self._settings.rig_user)
            client.set_password(self._password)
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
        client.application_uri = APPLICATION
        await client.set_security(
            SecurityPolicyBasic256Sha256,
            str(keys.folder / CERTIFICATE),
            str(keys.folder / PRIVATE_KEY),
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
