# SPDX-License-Identifier: Apache-2.0
"""Web server of the live page: sends snapshots over a websocket, and receives requests of the sliders.

It listens on this host alone by default. Connections from pages of other origins are refused, because requests can
command a rig.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable, Mapping
from http import HTTPStatus
from importlib.resources import files
from typing import Any

from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.sync.server import ServerConnection, serve

from drill_twin.errors import DrillTwinError, RunError

_PERIOD = 0.05  # s, between two snapshots
_LARGEST_REQUEST = 4096  # bytes
_LOCAL = {"127.0.0.1", "localhost", "[::1]"}

RequestHandler = Callable[[Mapping[str, Any]], None]
"""Carries out a request of the page; raises a DrillTwinError, which the page shows."""


class PageServer:
    """Server of the page for any number of browsers."""

    def __init__(
        self,
        snapshot: Callable[[], Mapping[str, Any]],
        on_request: RequestHandler,
        *,
        host: str = "127.0.0.1",
        port: int = 8000,
    ) -> None:
        """Start to serve.

        Args:
            snapshot: Returns the present state of the page.
            on_request: Called with each request of the page.
            host: Address to listen on.
            port: Port; 0 takes a free one.

        Raises:
            RunError: The port is taken.
        """
        self._snapshot, self._on_request, self._host = snapshot, on_request, host
        self._page = files("drill_twin.live").joinpath("page.html").read_bytes()
        self._updated = threading.Condition()
        self._text, self._number, self._closed = "{}", 0, False
        try:
            self._server = serve(
                self._serve_connection,
                host,
                port,
                process_request=self._respond,
                max_size=_LARGEST_REQUEST,
                compression=None,
            )
        except OSError as error:
            raise RunError(
                f"expected a free port for the page, found {host}:{port}: {error.strerror or error}; "
                "choose another with --port"
            ) from error
        self.port: int = self._server.socket.getsockname()[1]
        self.url = f"http://{'127.0.0.1' if host in {'', '0.0.0.0'} else host}:{self.port}/"  # noqa: S104 - not a bind
        self._threads = [
            threading.Thread(target=self._server.serve_forever, name="page", daemon=True),
            threading.Thread(target=self._update, name="snapshots", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """Close all connections and stop."""
        with self._updated:
            self._closed = True
            self._updated.notify_all()
        self._server.shutdown()
        for thread in self._threads:
            thread.join(5.0)

    def _update(self) -> None:
        """Encode one snapshot for all connections, at a steady rate."""
        while not self._closed:
            text = json.dumps(self._snapshot(), allow_nan=False)
            with self._updated:
                self._text, self._number = text, self._number + 1
                self._updated.notify_all()
            time.sleep(_PERIOD)

    def _respond(self, connection: ServerConnection, request: Request) -> Response | None:
        host = request.headers.get("Host", "")
        if self._host in {"127.0.0.1", "localhost", "::1"} and host.rpartition(":")[0] not in _LOCAL:
            return connection.respond(HTTPStatus.FORBIDDEN, "this page is for this host\n")
        if request.path == "/live":
            if request.headers.get("Origin", f"http://{host}") != f"http://{host}":
                return connection.respond(HTTPStatus.FORBIDDEN, "only the page of this server may ask\n")
            return None
        if request.path != "/":
            return connection.respond(HTTPStatus.NOT_FOUND, "there is one page: /\n")
        headers = Headers(
            {
                "Content-Type": "text/html; charset=utf-8",
                "Content-Length": str(len(self._page)),
                "Cache-Control": "no-store",
                "X-Frame-Options": "DENY",
                "Connection": "close",
            }
        )
        return Response(HTTPStatus.OK, "OK", headers, self._page)

    def _serve_connection(self, connection: ServerConnection) -> None:
        """Send each new snapshot, or the newest to a slow browser; handle its requests."""
        seen = 0
        try:
            while True:
                with self._updated:
                    self._updated.wait_for(lambda: self._closed or self._number != seen)  # noqa: B023 - called at once
                    text, seen = self._text, self._number
                    if self._closed:
                        return
                connection.send(text)
                self._handle_requests(connection)
        except ConnectionClosed:
            return

    def _handle_requests(self, connection: ServerConnection) -> None:
        while True:
            try:
                request = connection.recv(timeout=0)
            except TimeoutError:
                return
            try:
                self._on_request(_parsed(request))
                answer = ""
            except DrillTwinError as error:
                answer = str(error)
            connection.send(json.dumps({"error": answer}))


def _parsed(request: str | bytes) -> Mapping[str, Any]:
    """A request of the page: named finite numbers or booleans.

    Raises:
        DrillTwinError: Anything else.
    """
    try:
        content = json.loads(request)
    except (ValueError, RecursionError) as error:
        raise DrillTwinError(f"expected JSON from the page, found {request[:40]!r}") from error
    if not isinstance(content, dict) or not all(
        isinstance(value, bool) or (isinstance(value, int | float) and math.isfinite(value))
        for value in content.values()
    ):
        raise DrillTwinError(f"expected named numbers from the page, found {str(content)[:40]}")
    return content
