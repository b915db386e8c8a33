# SPDX-License-Identifier: Apache-2.0
"""Web server of the live page: its files, snapshots over a websocket, and requests of the sliders.

One thread serves all browsers, a second one makes the snapshots and carries out requests. A request can command a rig,
so only the requests of a page with a right are taken (`drill_twin_dashboard.live.access`). The files are HTML, CSS and
JavaScript modules of this package, and plotly.js of the plotly package.
"""

import asyncio
import gzip
import json
import math
import pkgutil
import socket
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache
from http import HTTPStatus
from importlib.resources import files
from typing import Any
from urllib.parse import urlsplit

from pydantic import FiniteFloat, TypeAdapter, ValidationError
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.files.json_files import JsonError, read_json
from drill_twin.core.loopback import is_loopback
from drill_twin.core.units.registry import si_factor
from drill_twin.core.units.system import SYSTEMS
from drill_twin_dashboard.live.access import READ_ONLY, TOO_LATE, WILDCARDS, Access, Links, same, url
from drill_twin_dashboard.live.web_server import DOWNLOAD, WebServer, listening_socket, send

_TYPES = {"html": "text/html", "css": "text/css", "js": "text/javascript"}
_PLOTLY = "/plotly.js"
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Everything comes from this server; plotly writes style attributes and shows heat maps as `data:` images."""


def page_files(package: str = "drill_twin_dashboard.live") -> dict[str, tuple[str, bytes]]:
    """Type and content of each file by its path on the server; `/` is the page.

    Args:
        package: Package with the folder `page` of the files.
    """
    found = {"/": ("text/html", b"")}
    for file in files(package).joinpath("page").iterdir():
        kind = _TYPES.get(file.name.rpartition(".")[2])
        if kind is not None:
            found["/" if file.name == "index.html" else f"/{file.name}"] = (kind, file.read_bytes())
    found["/unit_table.js"] = (_TYPES["js"], _unit_table().encode())
    return {**found, _PLOTLY: (_TYPES["js"], b"")}


_DIGITS = {
    "force": {"N": 1, "kN": 1, "klbf": 1, "tf": 1}, "rotation": {"rev/s": 2, "rpm": 0},
    "torque": {"N m": 3, "kN m": 2, "klbf ft": 2}, "rate": {"m/h": 1, "ft/h": 1}, "length": {"m": 1, "ft": 0},
    "offset": {"mm": 1, "in": 2}, "stress": {"MPa": 2, "ksi": 2},
}  # fmt: skip
"""Units that a reader of the page can choose for each quantity, with their digits."""


def _unit_table() -> str:
    """Module with the systems of `drill_twin.core.units.system`, and sizes of units; rotation is in rev/s."""
    systems = {name: {quantity: getattr(system, quantity) for quantity in _DIGITS} for name, system in SYSTEMS.items()}
    units = {
        quantity: {
            unit: [si_factor(unit)[0] / (math.tau if quantity == "rotation" else 1.0), digits]
            for unit, digits in row.items()
        }
        for quantity, row in _DIGITS.items()
    }
    return f"export const SYSTEMS = {json.dumps(systems)}, UNITS = {json.dumps(units)};\n"


def response(kind: str, content: bytes, policy: str = _POLICY, **more: str) -> Response:
    """Answer 200 with the headers of this page."""
    headers = Headers(
        {
            "Content-Type": f"{kind}; charset=utf-8",
            "Content-Length": str(len(content)),
            "Content-Security-Policy": policy,
            "Cache-Control": "no-store",
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
            "Referrer-Policy": "no-referrer",
            "Connection": "close",
            **more,
        }
    )
    return Response(HTTPStatus.OK, "OK", headers, content)


@cache
def _plotly() -> bytes:
    return gzip.compress(pkgutil.get_data("plotly", "package_data/plotly.min.js") or b"", 6, mtime=0)


MOST_CLIENTS = 32
"""Open pages; the next is answered with 503."""
KEPT = 4
"""Places among `MOST_CLIENTS` for pages that may command: readers get none of them, so they lock nobody out."""

_STRANGER, _ENTERED, _COMMANDS = range(3)
"""Rights of a client: none; it has the cookie; it has given the key too."""


class PageServer(WebServer):
    """Server of the page for a bounded number of browsers."""

    PUBLIC = True
    """Show snapshots to everybody who reaches this server; False: to pages that may command alone."""
    PERIOD = 0.05
    """Time between two snapshots [s]."""
    LARGEST_REQUEST = 4096
    """Size of a request [byte]."""
    REQUEST: TypeAdapter[Any] = TypeAdapter(dict[str, bool | int | FiniteFloat])
    """Form of a request."""

    def __init__(
        self,
        snapshot: Callable[[], Mapping[str, Any]],
        on_request: Callable[[Mapping[str, Any]], None],
        *,
        history: Callable[[], Mapping[str, Any]] = dict,
        host: str = "127.0.0.1",
        port: int = 8000,
        allowed_hosts: Collection[str] = (),
    ) -> None:
        """Start to serve.

        Args:
            snapshot: Returns the present state of the page.
            on_request: Carries out a request of the page, in a thread of the server; raises a DrillTwinError, which
                the page shows.
            history: Returns what a page shows of the minutes before it was opened, `/history.json`.
            host: Address to listen on.
            port: Port; 0 takes a free one.
            allowed_hosts: Names by which browsers may know this server, besides the machine's names.

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
        super().__init__(listener, access, "page", max_size=self.LARGEST_REQUEST)  # a place: `_STRANGER` to `_COMMANDS`

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
            await asyncio.sleep(self.PERIOD)

    async def _respond(self, connection: ServerConnection, request: Request) -> Response | None:
        path = urlsplit(request.path).path
        if path in {"/live", "/enter"} and self._access.is_foreign(request.headers):
            return connection.respond(HTTPStatus.FORBIDDEN, "only the page of this server may ask\n")
        if path == "/live":
            entered = self._access.has_cookie(request.headers)
            if not (entered or self.PUBLIC):
                self.links.show_beside()
                return connection.respond(HTTPStatus.FORBIDDEN, f"{READ_ONLY}\n")
            most = MOST_CLIENTS if entered else MOST_CLIENTS - KEPT
            if len(self.places) >= most:
                return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, f"{most} pages are open; close a page\n")
            self.places[connection] = _ENTERED if entered else _STRANGER
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
        kind, content = self._files[path]
        if path != _PLOTLY:
            return response(kind, content)
        return response(kind, _plotly(), **{"Content-Encoding": "gzip"})

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
            if self.PUBLIC or self.places.get(connection) == _COMMANDS:
                await send(connection, self._text)

    async def _handle_requests(self, connection: ServerConnection) -> None:
        async for request in connection:
            try:
                content = _parsed(request, self.REQUEST)
                if "key" in content and self.places.get(connection):
                    self.places[connection] = _COMMANDS if same(content["key"], self._access.key) else _ENTERED
                if self.places.get(connection) != _COMMANDS:
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


def _parsed(request: str | bytes, form: TypeAdapter[Any]) -> Mapping[str, Any]:
    """A request of the page: data of this form, or the key alone.

    Raises:
        DrillTwinError: Anything else.
    """
    try:
        content = read_json(request)
        if not (isinstance(content, dict) and set(content) == {"key"} and isinstance(content["key"], str)):
            form.validate_python(content, strict=True)
    except JsonError as error:
        raise DrillTwinError(f"expected JSON from the page, found {request[:40]!r}") from error
    except ValidationError as error:
        raise DrillTwinError(f"expected a request of the page, found {str(content)[:40]}") from error
    return dict(content)
