# SPDX-License-Identifier: Apache-2.0
"""Client with a certificate that commands through the gateway; a JSON list a line says what to do, and is answered.

["write", NAME, VALUE], ["read", NAME], ["beat", PERIOD] (0: no heartbeat from now on), ["time"] of the last write.
"""

import asyncio
import json
import sys
import time
from pathlib import Path

from asyncua import Client, ua
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256

TYPES = {"Request": ua.VariantType.Boolean, "Heartbeat": ua.VariantType.UInt32}


class Holder:
    def __init__(self, client, space):
        self._client, self._space = client, space
        self._beating = asyncio.ensure_future(asyncio.sleep(0))
        self._began = 0.0

    def _node(self, name):
        return self._client.get_node(ua.NodeId(name, self._space))

    async def write(self, name, value):
        self._began = time.monotonic()
        data = ua.DataValue(ua.Variant(value, TYPES.get(name, ua.VariantType.Double)))
        one = ua.WriteValue(NodeId=self._node(name).nodeid, AttributeId=ua.AttributeIds.Value, Value=data)
        try:
            (code,) = await self._client.uaclient.write(ua.WriteParameters(NodesToWrite=[one]))
        except ua.UaStatusCodeError as error:
            return type(error).__name__
        return code.name

    async def read(self, name):
        return await self._node(name).read_value()

    async def time(self):
        return self._began

    async def beat(self, period):
        self._beating.cancel()
        if period:
            self._beating = asyncio.ensure_future(self._beat(period))
        return True

    async def _beat(self, period):
        for number in range(1, 2**31):
            await self._node("Heartbeat").write_value(ua.Variant(number, ua.VariantType.UInt32))
            await asyncio.sleep(period)


async def main(url, keys, server, user, password):
    client = Client(url, timeout=20.0)  # of a busy machine
    client.application_uri = "urn:drill_twin:gateway"  # as in the certificate
    client.set_user(user)
    client.set_password(password)
    folder = Path(keys)
    await client.set_security(
        SecurityPolicyBasic256Sha256, str(folder / "certificate.der"), str(folder / "private_key.pem"), None, server
    )
    try:
        await client.connect()
    except Exception as error:  # noqa: BLE001 - the test wants its name
        print(json.dumps(type(error).__name__), flush=True)
        return
    space = (await client.get_namespace_array()).index("urn:drill_twin:gateway")
    holder = Holder(client, space)
    print(json.dumps("connected"), flush=True)
    while line := await asyncio.to_thread(sys.stdin.readline):
        what, *words = json.loads(line)
        print(json.dumps(await getattr(holder, what)(*words)), flush=True)
    await client.disconnect()


asyncio.run(main(*sys.argv[1:]))
