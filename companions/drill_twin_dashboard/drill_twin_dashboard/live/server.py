# SPDX-License-Identifier: Apache-2.0
"""Web server of the live page: sends snapshots over a websocket, and receives requests of the sliders.

One thread serves all browsers, a second one makes the snapshots and carries out requests. A request can command a rig,
so only the requests of a page with a right are taken (`drill_twin_dashboard.live.access`).
"""

from __future__ import annotations

import asyncio
import json
import math
import socket
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.files.json_files import JsonError, read_json
from drill_twin.core.loopback import is_loopback
from drill_twin_dashboard.live.access import READ_ONLY, TOO_LATE, WILDCARDS, Access, Links, url
from drill_twin_dashboard.live.page_files import file_response, page_files, response
from drill_twin_dashboard.live.web_server import DOWNLOAD, WebServer, listening_socket, send

MOST_CLIENTS = 32
"""Open pages; the next is answered with 503."""
KEPT = 4
"""Places among `MOST_CLIENTS` for pages that may command: readers get none of them, so they lock nobody out."""
_PERIOD = 0.05  # s, between two snapshots
_LARGEST_REQUEST = 4096  # bytes

RequestHandler = Callable[[Mapping[str, Any]], None]
"""Carries out a request of the page; raises a DrillTwinError, which the page shows."""


class PageServer(WebServer):
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
        self._snapshot, self._on_request = snapshot, on_request
        self._history, self._files = history, page_files()
        self._text, self._fresh = "{}", asyncio.Event()
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="snapshots")
        access, listener = Access(allowed_hosts), listening_socket(host, port, "the page", "--port")
        self.port: int = listener.getsockname()[1]
        self.url = url(host, self.port)
        """Address of the page on this machine, for reading."""
        remote = url(socket.gethostname() if host in WILDCARDS else host, self.port)
        own = is_loopback(listener.getsockname()[0])
        self.links = Links(access, [self.url] if own else [self.url, remote])
        """Links by which a page may command."""
        super().__init__(listener, access, "page", max_size=_LARGEST_REQUEST)  # a place: whether it has the cookie

    def close(self) -> None:
        """Close all connections and stop, within a few seconds whatever the clients do."""
        super().close()
        self._worker.shutdown(wait=False, cancel_futures=True)
        self.links.close()

    async def _work_beside(self) -> None:
        """Encode one snapshot for all clients, at a steady rate, while there are any."""
        while True:
            self.links.tidy()
            if self.places:
                self._text = await self._loop.run_in_executor(self._worker, _encoded, self._snapshot)
                before, self._fresh = self._fresh, asyncio.Event()
                before.set()
            await asyncio.sleep(_PERIOD)

    async def _respond(self, connection: ServerConnection, request: Request) -> Response | None:
        path = urlsplit(request.path).path
        if path in {"/live", "/enter"} and self._access.is_foreign(request.headers):
            return connection.respond(HTTPStatus.FORBIDDEN, "only the page of this server may ask\n")
        if path == "/live":
            entered = self._access.has_cookie(request.headers)
            most = MOST_CLIENTS if entered else MOST_CLIENTS - KEPT
            if len(self.places) >= most:
                return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, f"{most} pages are open already\n")
            self.places[connection] = entered
            return None
        if path == "/enter":
            if cookie := self._access.enter(request.headers):
                return response("text/plain", self._access.key.encode(), **{"Set-Cookie": cookie})
            self.links.show_beside()
            return connection.respond(HTTPStatus.FORBIDDEN, TOO_LATE)
        connection.close_timeout = DOWNLOAD
        if path == "/history.json":
            text = await self._loop.run_in_executor(self._worker, _encoded, self._history)
            return response("application/json", text.encode())
        if path not in self._files:
            return connection.respond(HTTPStatus.NOT_FOUND, "the page is at /\n")
        packed = "gzip" in ",".join(request.headers.get_all("Accept-Encoding"))
        return file_response(path, *self._files[path], packed=packed)

    async def _converse(self, connection: ServerConnection) -> None:
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
            await send(connection, self._text)

    async def _handle_requests(self, connection: ServerConnection) -> None:
        may = False
        async for request in connection:
            try:
                content = _parsed(request)
                if "key" in content:
                    may = self.places.get(connection, False) and self._access.is_key(content["key"])
                if not may:
                    self.links.show_beside()
                    raise DrillTwinError(READ_ONLY)
                if "key" not in content:
                    await self._loop.run_in_executor(self._worker, self._on_request, content)
                answer = ""
            except DrillTwinError as error:
                answer = str(error)
            await send(connection, json.dumps({"error": answer}))


def _encoded(content: Callable[[], Mapping[str, Any]]) -> str:
    return json.dumps(content(), allow_nan=False)


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
