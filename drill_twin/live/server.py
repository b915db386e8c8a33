# SPDX-License-Identifier: Apache-2.0
"""Serves the page and keeps it up to date over a websocket; takes what its sliders ask for.

It listens on this host alone unless told otherwise, and a page from elsewhere that is open in the same browser is
turned away: who commands a rig must have come from here.
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

_PERIOD = 0.05  # s between two pictures
_LONGEST = 4096  # bytes of a request
_LOCAL = {"127.0.0.1", "localhost", "[::1]"}

Asked = Callable[[Mapping[str, Any]], None]
"""Does what the page asks for; raises a DrillTwinError that the page shows."""


class PageServer:
    """The page, live, for any number of browsers."""

    def __init__(
        self, picture: Callable[[], Mapping[str, Any]], asked: Asked, *, host: str = "127.0.0.1", port: int = 8000
    ) -> None:
        """Begin to serve.

        Args:
            picture: What the page shows now.
            asked: Called with what the page asks for.
            host: Address to listen on.
            port: Port; 0 takes a free one.

        Raises:
            RunError: The port is taken.
        """
        self._picture, self._asked, self._host = picture, asked, host
        self._page = files("drill_twin.live").joinpath("page.html").read_bytes()
        self._news = threading.Condition()
        self._text, self._number, self._over = "{}", 0, False
        try:
            self._server = serve(
                self._talk, host, port, process_request=self._answer, max_size=_LONGEST, compression=None
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
            threading.Thread(target=self._tell, name="pictures", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """Send everybody away."""
        with self._news:
            self._over = True
            self._news.notify_all()
        self._server.shutdown()
        for thread in self._threads:
            thread.join(5.0)

    def _tell(self) -> None:
        """One picture for all, at a steady rate."""
        while not self._over:
            text = json.dumps(self._picture(), allow_nan=False)
            with self._news:
                self._text, self._number = text, self._number + 1
                self._news.notify_all()
            time.sleep(_PERIOD)

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
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

    def _talk(self, connection: ServerConnection) -> None:
        """Send each new picture, or the newest where the browser is slow; take what it asks."""
        seen = 0
        try:
            while True:
                with self._news:
                    self._news.wait_for(lambda: self._over or self._number != seen)  # noqa: B023 - within the turn
                    text, seen = self._text, self._number
                    if self._over:
                        return
                connection.send(text)
                self._take(connection)
        except ConnectionClosed:
            return

    def _take(self, connection: ServerConnection) -> None:
        while True:
            try:
                request = connection.recv(timeout=0)
            except TimeoutError:
                return
            try:
                self._asked(_read(request))
                answer = ""
            except DrillTwinError as error:
                answer = str(error)
            connection.send(json.dumps({"error": answer}))


def _read(request: str | bytes) -> Mapping[str, Any]:
    """What the page asks for: a few named finite numbers or truths, and nothing else."""
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
