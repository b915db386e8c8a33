# SPDX-License-Identifier: Apache-2.0
"""Websocket server in a thread of its own, which the live page and the port for viewers share.

Connections are bounded. A request is checked by its head (`drill_twin_dashboard.live.access`) before it gets a place,
and a client that does not ask, read or leave in time is dropped.
"""

import asyncio
import logging
import socket
import threading
from contextlib import suppress
from functools import partial
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from drill_twin.core.errors import RunError
from drill_twin_dashboard.live.access import Access

MOST_CONNECTIONS = 128
"""Open connections of a server, including connections that have not asked for anything yet."""
PATIENCE = 2.0
"""Time for a client to ask after it has connected, to read what is sent, and to leave at the end [s]."""
DOWNLOAD = 20.0
"""Time for a client to receive a file [s]."""
_MOST_REQUESTS = 16  # of one client, that wait
_LOG = logging.getLogger(f"{__name__}.websockets")
_LOG.setLevel(logging.CRITICAL)  # what a client does wrong is no error of this program


class WebServer:
    """Server of a bounded number of clients; a subclass answers requests, and talks with the clients that get a place.

    Attributes:
        connections: Open connections, the oldest first, with or without a place.
        places: Clients with a place, and what the subclass keeps of each.
    """

    def __init__(self, listener: socket.socket, access: Access, name: str, **options: Any) -> None:
        """Start to serve.

        Args:
            listener: Socket that listens, from `listening_socket`.
            access: Checks the heads of requests.
            name: Name of the thread.
            options: Further options of `websockets.asyncio.server.serve`.
        """
        self._access, self._options = access, options
        self.connections: dict[ServerConnection, None] = {}
        self.places: dict[ServerConnection, Any] = {}
        self._loop, self._over = asyncio.new_event_loop(), asyncio.Event()
        self._thread = threading.Thread(target=self._run, args=(listener,), name=name, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Close all connections and stop, within a few seconds whatever the clients do."""
        with suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join(3.0 * PATIENCE)

    def _run(self, listener: socket.socket) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._serve(listener))

    async def _serve(self, listener: socket.socket) -> None:
        server = await serve(
            self._converse, sock=listener, process_request=self._answer, logger=_LOG, max_queue=_MOST_REQUESTS,
            create_connection=partial(_Connection, self),  # type: ignore[arg-type]  # a factory is enough
            compression=None, open_timeout=DOWNLOAD, close_timeout=PATIENCE / 2.0, **self._options,
        )  # fmt: skip
        beside = asyncio.create_task(self._work_beside())
        await self._over.wait()
        beside.cancel()
        server.close()
        try:
            await asyncio.wait_for(asyncio.shield(server.wait_closed()), PATIENCE)
        except TimeoutError:
            for connection in list(self.connections):
                connection.transport.abort()

    async def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        refused = self._access.refusal(request.headers)
        return await self._respond(connection, request) if refused is None else connection.respond(*refused)

    async def _respond(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answer a request to this server; None after a place was given, on which the websocket is opened."""
        raise NotImplementedError

    async def _converse(self, connection: ServerConnection) -> None:
        """Talk with a client that has a place, until it leaves."""
        raise NotImplementedError

    async def _work_beside(self) -> None:
        """Do the work of the server that no client asks for, in a task that is cancelled at the end."""


class _Connection(ServerConnection):
    """Connection that is counted from its first byte to its last."""

    def __init__(self, server: WebServer, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._web_server = server

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Drop the oldest without a place if there are too many: a client that asks at once is always served."""
        super().connection_made(transport)
        connections = self._web_server.connections
        connections[self] = None
        if len(connections) > MOST_CONNECTIONS:
            oldest = next(one for one in connections if one not in self._web_server.places)
            del connections[oldest]
            oldest.transport.abort()
        self.loop.call_later(PATIENCE, self._drop_silent)

    def _drop_silent(self) -> None:
        if self.request is None:
            self.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the client."""
        self._web_server.connections.pop(self, None)
        self._web_server.places.pop(self, None)
        super().connection_lost(exc)


async def send(connection: ServerConnection, text: str) -> None:
    """Send a text; drop a client that does not read."""
    try:
        await asyncio.wait_for(connection.send(text), PATIENCE)
    except TimeoutError:
        connection.transport.abort()
        raise ConnectionClosed(None, None) from None


def listening_socket(host: str, port: int, what: str, option: str) -> socket.socket:
    """A socket that listens for `what`.

    Raises:
        RunError: The port is taken, or the address is none of this machine; `option` chooses another port.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family, backlog=MOST_CONNECTIONS)
    except (OSError, UnicodeError, OverflowError, TypeError) as error:
        said = getattr(error, "strerror", None) or error
        remedy = f"choose another with {option}" if not isinstance(error, socket.gaierror) else "choose another --host"
        raise RunError(f"expected a free port for {what}, found {host[:100]}:{port}: {said}; {remedy}") from error
