# SPDX-License-Identifier: Apache-2.0
"""Server of a rig with asyncua: writes its variables twenty times a second; a JSON list a line changes one.

["set", NAME, VALUE], ["stamp", SECONDS] by which source timestamps are off from now on.
"""

import asyncio
import json
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

from asyncua import Server, ua

UNITS = {"WOB": "kN", "Hook": "kN", "RPM": "rpm", "Torque": "N m", "Wrong": "lbf", "WOBSet": "N", "RPMSet": "rpm"}


async def main(port, keys=""):
    server = Server()
    await server.init()
    server.set_endpoint(f"opc.tcp://127.0.0.1:{port}/rig")
    await server.set_application_uri("urn:drill_twin:gateway")
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    if keys:
        await server.load_certificate(str(Path(keys) / "certificate.der"))
        await server.load_private_key(str(Path(keys) / "private_key.pem"))
        server.set_security_policy([ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt])
    space = await server.register_namespace("urn:rig")
    nodes, values, off = {}, dict.fromkeys(UNITS, 10.0), [0.0]
    for name, unit in UNITS.items():
        nodes[name] = await server.nodes.objects.add_variable(ua.NodeId(name, space), name, 10.0)
        await nodes[name].add_property(
            ua.NodeId(f"{name}.unit", space),
            ua.QualifiedName("EngineeringUnits", 0),
            ua.EUInformation(DisplayName=ua.LocalizedText(unit)),
        )

    async def update():
        while True:
            now = datetime.now(UTC) + timedelta(seconds=off[0])
            for name, node in nodes.items():
                data = ua.DataValue(ua.Variant(values[name], ua.VariantType.Double), SourceTimestamp=now)
                await server.write_attribute_value(node.nodeid, data)
            await asyncio.sleep(0.05)

    async with server:
        updating = asyncio.ensure_future(update())
        print(json.dumps("serving"), flush=True)
        while line := await asyncio.to_thread(sys.stdin.readline):
            what, *words = json.loads(line)
            if what == "set":
                values[words[0]] = words[1]
            else:
                off[0] = words[0]
            print(json.dumps("done"), flush=True)
        updating.cancel()


asyncio.run(main(*sys.argv[1:]))
