# SPDX-License-Identifier: Apache-2.0
"""Web server of the live page: sends snapshots over a websocket, and receives requests of the sliders.

One thread serves all browsers, a second one makes the snapshots and carries out requests. Clients and their queues are
bounded; one that does not read is dropped. Requests can command a rig: those of a page with a right are taken
(`drill_twin_dashboard.live.access`).
"""

from __future__ import annotations

import asyncio
import json
import logging
import math
import socket
import threading
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from drill_twin.core.errors import DrillTwinError, RunError
from drill_twin.core.files.json_files import JsonError, read_json
from drill_twin.core.loopback import is_loopback
from drill_twin_dashboard.live.access import READ_ONLY, TOO_LATE, WILDCARDS, Access, Links, url
from drill_twin_dashboard.live.page_files import file_response, page_files, response

MOST_CLIENTS = 32
"""Open pages; the next is answered with 503."""
KEPT = 4
"""Places among them for pages that may command: readers get none of these, so that they lock nobody out."""
MOST_CONNECTIONS = 128  # those that have not asked for anything yet included
_PERIOD = 0.05  # s, between two snapshots
_PATIENCE = 2.0  # s; for a client to read a snapshot, to ask after it has connected, and to leave at the end
_DOWNLOAD = 20.0  # s; to receive a file
_LARGEST_REQUEST = 4096  # bytes
_MOST_WAITING = 16  # requests of one client
_LOG = logging.getLogger(f"{__name__}.websockets")
_LOG.setLevel(logging.CRITICAL)  # what a client does wrong is no error of this program

RequestHandler = Callable[[Mapping[str, Any]], None]
"""Carries out a request of the page; raises a DrillTwinError, which the page shows."""


class PageServer:
    """Server of the page for a bounded number of browsers."""

    def __init__(
        self,
        snapshot: Callable[[], Mapping[str, Any]],
        on_request: RequestHandler,
        *,
        history: Callable[[], Mapping[str, Any]] = dict,
        host: str = "127.0.0.1",
        port: int = 8000,
        allowed_hosts: Collection[str] = (),
    ) -> None:
        """Start to serve.

        Args:
            snapshot: Returns the present state of the page.
            on_request: Called with each request of the page, in a thread of the server.
            history: Returns what a page shows of the minutes before it was opened, `/history.json`.
            host: Address to listen on.
            port: Port; 0 takes a free one.
            allowed_hosts: Names by which browsers may know this server, besides those of this machine.

        Raises:
            RunError: The port is taken, or the address is none of this machine.
        """
        self._snapshot, self._on_request, self._access = snapshot, on_request, Access(allowed_hosts)
        self._history, self._files = history, page_files()
        self._clients: dict[ServerConnection, bool] = {}  # with the cookie of a page that may command, or without
        self.connections: dict[ServerConnection, None] = {}
        """Connections, the oldest first, those included that have not asked for anything."""
        self._text, self._fresh = "{}", asyncio.Event()
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="snapshots")
        listener = listening_socket(host, port, "the page", "--port")
        self.port: int = listener.getsockname()[1]
        self.url = url(host, self.port)
        """Address of the page on this machine, for reading."""
        remote = url(socket.gethostname() if host in WILDCARDS else host, self.port)
        own = is_loopback(listener.getsockname()[0])
        self.links = Links(self._access, [self.url] if own else [self.url, remote])
        """Links by which a page may command."""
        self._loop = asyncio.new_event_loop()
        self._over = asyncio.Event()
        self._thread = threading.Thread(target=self._run, args=(listener,), name="page", daemon=True)
        self._thread.start()

    @property
    def running(self) -> bool:
        """True until the server has ended."""
        return self._thread.is_alive()

    def close(self) -> None:
        """Close all connections and stop, within a few seconds whatever the clients do."""
        with suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join(3.0 * _PATIENCE)
        self._worker.shutdown(wait=False, cancel_futures=True)
        self.links.close()

    def _run(self, listener: socket.socket) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._serve(listener))

    async def _serve(self, listener: socket.socket) -> None:
        server = await serve(
            self._serve_connection,
            sock=listener,
            process_request=self._respond,
            create_connection=partial(_Connection, self),  # type: ignore[arg-type]  # a factory is enough
            logger=_LOG,
            max_size=_LARGEST_REQUEST,
            max_queue=_MOST_WAITING,
            compression=None,
            open_timeout=_DOWNLOAD,
            close_timeout=_PATIENCE / 2.0,
        )
        update = asyncio.create_task(self._update())
        await self._over.wait()
        update.cancel()
        server.close()
        try:
            await asyncio.wait_for(asyncio.shield(server.wait_closed()), _PATIENCE)
        except TimeoutError:
            for connection in list(self.connections):
                connection.transport.abort()

    async def _update(self) -> None:
        """Encode one snapshot for all clients, at a steady rate, while there are any."""
        while True:
            self.links.tidy()
            if self._clients:
                self._text = await self._loop.run_in_executor(self._worker, _encoded, self._snapshot)
                before, self._fresh = self._fresh, asyncio.Event()
                before.set()
            await asyncio.sleep(_PERIOD)

    async def _respond(self, connection: ServerConnection, request: Request) -> Response | None:
        refused = self._access.refusal(request.headers)
        if refused is not None:
            return connection.respond(*refused)
        path = urlsplit(request.path).path
        if path in {"/live", "/enter"} and self._access.is_foreign(request.headers):
            return connection.respond(HTTPStatus.FORBIDDEN, "only the page of this server may ask\n")
        if path == "/live":
            entered = self._access.has_cookie(request.headers)
            most = MOST_CLIENTS if entered else MOST_CLIENTS - KEPT
            if len(self._clients) >= most:
                return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, f"{most} pages are open already\n")
            self._clients[connection] = entered
            return None
        if path == "/enter":
            if cookie := self._access.enter(request.headers):
                return response("text/plain", self._access.key.encode(), **{"Set-Cookie": cookie})
            self.links.show_beside()
            return connection.respond(HTTPStatus.FORBIDDEN, TOO_LATE)
        connection.close_timeout = _DOWNLOAD
        if path == "/history.json":
            text = await self._loop.run_in_executor(self._worker, _encoded, self._history)
            return response("application/json", text.encode())
        if path not in self._files:
            return connection.respond(HTTPStatus.NOT_FOUND, "the page is at /\n")
        packed = "gzip" in ",".join(request.headers.get_all("Accept-Encoding"))
        return file_response(path, *self._files[path], packed=packed)

    async def _serve_connection(self, connection: ServerConnection) -> None:
        """Send snapshots and handle requests until the client leaves."""
        sending = asyncio.create_task(self._send_snapshots(connection))
        try:
            await self._handle_requests(connection)
        except ConnectionClosed:
            pass
        finally:
            sending.cancel()
            with suppress(asyncio.CancelledError, ConnectionClosed):
                await sending

    async def _send_snapshots(self, connection: ServerConnection) -> None:
        """Send each new snapshot, or the newest to a slow browser."""
        while True:
            await self._fresh.wait()
            await _send(connection, self._text)

    async def _handle_requests(self, connection: ServerConnection) -> None:
        may = False
        async for request in connection:
            try:
                content = _parsed(request)
                if "key" in content:
                    may = self._clients.get(connection, False) and self._access.is_key(content["key"])
                if not may:
                    self.links.show_beside()
                    raise DrillTwinError(READ_ONLY)
                if "key" not in content:
                    await self._loop.run_in_executor(self._worker, self._on_request, content)
                answer = ""
            except DrillTwinError as error:
                answer = str(error)
            await _send(connection, json.dumps({"error": answer}))

    def oldest(self) -> ServerConnection:
        """Take the oldest connection that has no place off the list."""
        found = next(one for one in self.connections if one not in self._clients)
        del self.connections[found]
        return found

    def forget(self, connection: ServerConnection) -> None:
        """Note that a client is gone."""
        self._clients.pop(connection, None)


class _Connection(ServerConnection):
    """Connection that is counted from its first byte to its last."""

    def __init__(self, page: PageServer, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._page = page

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Drop the oldest without a place if it is too many: who asks at once is served, however many are silent."""
        super().connection_made(transport)
        self._page.connections[self] = None
        if len(self._page.connections) > MOST_CONNECTIONS:
            self._page.oldest().transport.abort()
        self.loop.call_later(_PATIENCE, self._drop_silent)

    def _drop_silent(self) -> None:
        if self.request is None:
            self.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the client."""
        self._page.connections.pop(self, None)
        self._page.forget(self)
        super().connection_lost(exc)


def _encoded(content: Callable[[], Mapping[str, Any]]) -> str:
    return json.dumps(content(), allow_nan=False)


async def _send(connection: ServerConnection, text: str) -> None:
    """Send a text; drop a client that does not read."""
    try:
        await asyncio.wait_for(connection.send(text), _PATIENCE)
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


def _parsed(request: str | bytes) -> Mapping[str, Any]:
    """A request of the page: named finite numbers or booleans, or the key alone.

    Raises:
        DrillTwinError: Anything else.
    """
    try:
        content = read_json(request)
    except JsonError as error:
        raise DrillTwinError(f"expected JSON from the page, found {request[:40]!r}") from error
    if isinstance(content, dict) and set(content) == {"key"} and isinstance(content["key"], str):
        return content
    if not isinstance(content, dict) or not all(
        isinstance(value, bool) or (isinstance(value, int | float) and math.isfinite(value))
        for value in content.values()
    ):
        raise DrillTwinError(f"expected named numbers from the page, found {str(content)[:40]}")
    return content
