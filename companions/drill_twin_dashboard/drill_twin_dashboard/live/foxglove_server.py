# SPDX-License-Identifier: Apache-2.0
"""Topics over the Foxglove protocol (`foxglove.sdk.v1`), for Foxglove and other viewers that speak it; reading only.

A viewer that reads needs five messages of the protocol (github.com/foxglove/ws-protocol, docs/spec.md): the server
names itself and its channels, the viewer subscribes and unsubscribes, and each message of a topic is sent with the
number of the subscription and the time at which it was received.
"""

import json
import logging
import struct
import time as clock
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import ServerConnection, broadcast
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from drill_twin.core.files.json_files import JsonError, read_json
from drill_twin.core.loopback import in_url
from drill_twin.io.messages.topics import TOPICS
from drill_twin.io.messages.type_store import definition
from drill_twin_dashboard.live.access import Access
from drill_twin_dashboard.live.web_server import PATIENCE, WebServer, listening_socket, send

MOST_VIEWERS = 16
"""Open viewers; the next is answered with 503."""
_LARGEST_REQUEST = 16_384  # bytes
_MOST_WAITING = 1 << 20  # bytes for one viewer
_LOG = logging.getLogger(__name__)
_DATA = struct.Struct("<BIQ")  # operation 1, number of the subscription, time [ns]; the message follows


@dataclass
class _Viewer:
    """Subscriptions of a viewer, and whether it reads."""

    numbers: dict[str, int] = field(default_factory=dict)
    """Number of its subscription by topic."""
    told: bool = False
    """True once the channels are sent to it; it is then told of a new one."""
    had_room: float = 0.0
    """Monotonic time at which no more than `_MOST_WAITING` waited for it [s]."""


class FoxgloveServer(WebServer):
    """Server for viewers."""

    def __init__(self, host: str, port: int, allowed: Collection[str] = ()) -> None:
        """Start to serve.

        Args:
            host: Address to listen on.
            port: Port; 0 takes a free one.
            allowed: Names of this server besides the machine's names, and origins whose pages may ask.

        Raises:
            RunError: The port is taken.
        """
        listener = listening_socket(host, port, "viewers", "--foxglove")
        self.url = f"ws://{in_url(host)}:{listener.getsockname()[1]}"
        """Address for viewers."""
        self._channels: dict[int, str] = {}
        self._latched: dict[str, tuple[bytes, int]] = {}
        protocol = [Subprotocol("foxglove.sdk.v1")]
        super().__init__(listener, Access(allowed), "viewers", subprotocols=protocol, max_size=_LARGEST_REQUEST)

    def publish(self, topic: str, raw: bytes, time: int) -> None:
        """Pass a message on, with the time at which it was received [ns]."""
        with suppress(RuntimeError):  # the server has ended
            self._loop.call_soon_threadsafe(self._publish, topic, raw, time)

    def offer(self, topic: str) -> None:
        """Offer a topic to the viewers that are here, and to later ones."""
        self._loop.call_soon_threadsafe(self._offer, topic)

    def _offer(self, topic: str) -> None:
        number = len(self._channels) + 1
        self._channels[number] = topic
        told = [connection for connection, viewer in self.places.items() if viewer.told]
        broadcast(told, _advertised({number: topic}))

    def _publish(self, topic: str, raw: bytes, time: int) -> None:
        if TOPICS[topic].latched:
            self._latched[topic] = (raw, time)
        for connection, viewer in list(self.places.items()):
            if topic in viewer.numbers:
                _pass_on(connection, viewer, topic, raw, time)

    async def _respond(self, connection: ServerConnection, request: Request) -> Response | None:
        if not self._access.may_view(request.headers):
            text = "pages of this origin may not ask; start drill-twin watch with --allow-host NAME\n"
            return connection.respond(HTTPStatus.FORBIDDEN, text)
        if len(self.places) >= MOST_VIEWERS:
            return connection.respond(
                HTTPStatus.SERVICE_UNAVAILABLE, f"{MOST_VIEWERS} viewers are open; close a viewer\n"
            )
        self.places[connection] = _Viewer()
        return None

    async def _converse(self, connection: ServerConnection) -> None:
        about = {"name": "drill_twin", "capabilities": [], "supportedEncodings": [], "metadata": {}}
        with suppress(ConnectionClosed):
            await send(connection, json.dumps({"op": "serverInfo", **about}))
            self.places[connection].told = True
            await send(connection, _advertised(self._channels))
            async for request in connection:
                # No answer to what is no request of the protocol, or a request that this server does not offer.
                with suppress(JsonError, AttributeError, KeyError, OverflowError, TypeError, ValueError):
                    self._take(connection, read_json(request))

    def _take(self, connection: ServerConnection, request: Any) -> None:
        viewer: _Viewer = self.places[connection]
        if request["op"] == "unsubscribe":
            ended = set(request["subscriptionIds"])
            viewer.numbers = {topic: number for topic, number in viewer.numbers.items() if number not in ended}
        elif request["op"] == "subscribe":
            for one in request["subscriptions"]:
                topic, number = self._channels.get(one["channelId"], ""), int(one["id"])
                if topic and 0 <= number < 1 << 32:
                    viewer.numbers[topic] = number
                    if topic in self._latched:
                        _pass_on(connection, viewer, topic, *self._latched[topic])


def _advertised(channels: Mapping[int, str]) -> str:
    """Request with which the server names channels."""
    rows = [
        {"id": number, "topic": topic, "encoding": "cdr", "schemaName": TOPICS[topic].type_name,
         "schema": definition(TOPICS[topic].type_name), "schemaEncoding": "ros2msg"}
        for number, topic in channels.items()
    ]  # fmt: skip
    return json.dumps({"op": "advertise", "channels": rows})


def _pass_on(connection: ServerConnection, viewer: _Viewer, topic: str, raw: bytes, time: int) -> None:
    """Send a message of a subscribed topic, or leave it out while much waits; close a viewer that does not read."""
    now = clock.monotonic()
    if connection.transport.get_write_buffer_size() <= _MOST_WAITING:
        viewer.had_room = now
        broadcast([connection], _DATA.pack(1, viewer.numbers[topic], time) + raw)
    elif now - viewer.had_room > PATIENCE:
        _LOG.warning("a viewer that did not read for %g s was closed", PATIENCE)
        connection.transport.abort()
