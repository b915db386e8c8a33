# SPDX-License-Identifier: Apache-2.0
"""Client of the gateway with asyncua: prints as JSON what it reads, or all that it finds and may do."""

import asyncio
import json
import sys

from asyncua import Client, ua


async def _names(client, node_id):
    array = client.uris
    return f"{array[node_id.NamespaceIndex].rstrip('/')}/{node_id.Identifier}"


async def _read(client, space):
    found = {}
    for node in await client.get_node(ua.NodeId("Signals", space)).get_children():
        value = await node.read_data_value(raise_on_bad_status=False)
        unit = await (await node.get_child("0:EngineeringUnits")).read_value()
        found[node.nodeid.Identifier] = {
            "value": value.Value.Value,
            "status": value.StatusCode.value,
            "unit": unit.DisplayName.Text,
            "unit_id": unit.UnitId,
        }
    return found


async def _semantics(client, space):
    found = {}
    for point in await client.get_node(ua.NodeId("DataPoints", space)).get_children():
        facts = {}
        for subject in (client.get_node(ua.NodeId(point.nodeid.Identifier.removesuffix("#01"), space)), point):
            for link in await subject.get_references(direction=ua.BrowseDirection.Forward):
                if isinstance(link.ReferenceTypeId.Identifier, str):
                    names = facts.setdefault(link.ReferenceTypeId.Identifier, [])
                    names.append(await _names(client, link.NodeId))
        facts["BelongsToClass"] = sorted(set(facts["BelongsToClass"]) - {"http://ddhub.no/DynamicDrillingSignal"})
        found[point.nodeid.Identifier.removesuffix("#01")] = facts
    return found


async def _write(client, space, name, value):
    try:
        await client.get_node(ua.NodeId(name, space)).write_value(value)
    except ua.UaStatusCodeError as error:
        return type(error).__name__
    return "Good"


async def _read_later(client, space, before):
    """Values once simulated time has gone on; a busy machine may take a while."""
    for _ in range(100):
        found = await _read(client, space)
        if found["SimulatedTime"]["value"] > before:
            break
        await asyncio.sleep(0.1)
    return found


async def main(what, url):
    async with Client(url) as client:
        client.uris = await client.get_namespace_array()
        space = client.uris.index("urn:drill_twin:gateway")
        if what == "read":
            return await _read(client, space)
        found = {"read": await _read(client, space), "semantics": await _semantics(client, space)}
        before, written = found["read"]["SimulatedTime"]["value"], await _write(client, space, "WOB", 100.0)
        return found | {"written": written, "later": await _read_later(client, space, before)}


print(json.dumps(asyncio.run(main(*sys.argv[1:]))))
