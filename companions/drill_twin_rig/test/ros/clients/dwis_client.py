# SPDX-License-Identifier: Apache-2.0
"""Client that knows the vocabulary of D-WIS alone, no node and no name of the gateway: asks for data points by facts.

dwis_client.py URL FACT... prints as JSON, by number, the data points of which each FACT `VERB=NOUN` holds: they have
this verb with the noun, or with something that belongs to its class. Of each it prints classes, value and unit.
"""

import asyncio
import json
import sys

from asyncua import Client, ua

FORWARD, INVERSE = ua.BrowseDirection.Forward, ua.BrowseDirection.Inverse


class Vocabulary:
    def __init__(self, client, index):
        self._client, self._index = client, index

    def node(self, noun):
        return self._client.get_node(ua.NodeId(noun, self._index))

    async def linked(self, node, verb, direction):
        """Nodes that a verb links with a node."""
        found = await node.get_references(ua.NodeId(verb, self._index), direction)
        return [self._client.get_node(one.NodeId) for one in found]

    async def points(self, verb, noun):
        """Ids of the data points of which a fact holds."""
        objects = [self.node(noun)]
        if verb != "BelongsToClass":
            objects += await self.linked(objects[0], "BelongsToClass", INVERSE)
        subjects = [await self.linked(one, verb, INVERSE) for one in objects]
        return {one.nodeid for found in subjects for one in found}

    async def described(self, point):
        values = await self.linked(point, "HasDynamicValue", FORWARD)
        if not values:
            return None
        read = await values[0].read_data_value(raise_on_bad_status=False)
        names = lambda nodes: [one.nodeid.Identifier for one in nodes]  # noqa: E731
        return {
            "classes": names(await self.linked(point, "BelongsToClass", FORWARD)),
            "unit": names(await self.linked(values[0], "HasUnitOfMeasure", FORWARD)),
            "value": read.Value.Value,
            "good": read.StatusCode.is_good(),
        }


async def main(url, *facts):
    async with Client(url) as client:
        words = Vocabulary(client, await client.get_namespace_index("http://ddhub.no/"))
        sets = [await words.points(*fact.split("=")) for fact in facts]
        found = [await words.described(client.get_node(one)) for one in set.intersection(*sets)]
        return {str(number): one for number, one in enumerate(found) if one}


print(json.dumps(asyncio.run(main(*sys.argv[1:]))))
