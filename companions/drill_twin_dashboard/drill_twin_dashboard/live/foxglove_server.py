# SPDX-License-Identifier: Apache-2.0
"""Topics over the Foxglove protocol (`foxglove.sdk.v1`), for Foxglove and other viewers that speak it; reading only.

The library takes any Origin and Host, and any number of idle clients. A gate before it checks the head of a request as
the page does (`drill_twin_dashboard.live.access`), then passes bytes on both ways. A viewer that does not read is
closed, so that little waits for it.
"""

from __future__ import annotations

import asyncio
import logging
import secrets
import socket
import threading
from collections.abc import Collection
from contextlib import suppress
from http import HTTPStatus
from types import ModuleType, SimpleNamespace
from typing import Any

from websockets.datastructures import Headers

from drill_twin.core.errors import RunError, missing
from drill_twin.core.loopback import in_url
from drill_twin.io.messages.topics import TOPICS
from drill_twin.io.messages.type_store import definition
from drill_twin_dashboard.live.access import Access
from drill_twin_dashboard.live.server import listening_socket

MOST_VIEWERS = 16
"""Open viewers; the next is answered with 503."""
_MOST_CONNECTIONS = 64  # those that have not asked for anything yet included
_PATIENCE = 2.0  # s; for a viewer to ask after it has connected, and to read what is sent
_LARGEST_HEAD = 16_384  # bytes
_MOST_WAITING = 1 << 20  # bytes for one viewer
_LOG = logging.getLogger(__name__)

Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]


class ViewerGate:
    """Listens for viewers and passes those that may ask on to a server at an address of this machine."""

    def __init__(self, listener: socket.socket, server: tuple[str, int], allowed: Collection[str]) -> None:
        """Start to listen.

        Args:
            listener: Socket of the gate.
            server: Address and port behind it.
            allowed: Names of the gate besides those of this machine, and origins of pages that may ask.
        """
        self._server, self._access = server, Access(allowed)
        self._open: set[asyncio.StreamWriter] = set()
        self._viewers = 0
        self._loop, self._over = asyncio.new_event_loop(), asyncio.Event()
        self._thread = threading.Thread(target=self._run, args=(listener,), name="viewers", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Close all connections and stop, whatever the viewers do."""
        with suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join(3.0 * _PATIENCE)

    def _run(self, listener: socket.socket) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._listen(listener))

    async def _listen(self, listener: socket.socket) -> None:
        server = await asyncio.start_server(self._serve, sock=listener, limit=_LARGEST_HEAD)
        await self._over.wait()
        server.close()
        for writer in list(self._open):
            writer.transport.abort()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Check a request, and pass it on until one of the two ends."""
        self._open.add(writer)
        try:
            if len(self._open) > _MOST_CONNECTIONS:
                return
            async with asyncio.timeout(_PATIENCE):
                head = await reader.readuntil(b"\r\n\r\n")
            refused = self._refusal(head)
            if refused is not None:
                await _refuse(writer, *refused)
                return
            self._viewers += 1
            try:
                await self._pass_on(head, (reader, writer))
            finally:
                self._viewers -= 1
        except TimeoutError:
            _LOG.warning("a viewer that did not ask or read for %g s was closed", _PATIENCE)
        except (asyncio.IncompleteReadError, asyncio.LimitOverrunError, OSError):
            pass  # it left, or sent no request
        finally:
            self._open.discard(writer)
            writer.transport.abort()

    def _refusal(self, head: bytes) -> tuple[HTTPStatus, str] | None:
        """Status and sentence for a request that may not pass."""
        headers = Headers()
        for line in head.decode("latin-1").split("\r\n")[1:-2]:
            name, colon, value = line.partition(":")
            if not colon or name != name.strip() or not name.isprintable() or not value.isprintable():
                return HTTPStatus.BAD_REQUEST, "expected lines as NAME: VALUE\n"
            headers[name] = value.strip()
        refused = self._access.refusal(headers)
        if refused is None and not self._access.may_view(headers):
            return HTTPStatus.FORBIDDEN, "pages of this origin may not ask; start it with --allow-host NAME\n"
        if refused is None and self._viewers >= MOST_VIEWERS:
            return HTTPStatus.SERVICE_UNAVAILABLE, f"{MOST_VIEWERS} viewers are open already\n"
        return refused

    async def _pass_on(self, head: bytes, viewer: Streams) -> None:
        behind = await asyncio.open_connection(*self._server)
        try:
            behind[1].write(head)
            async with asyncio.TaskGroup() as both:
                ways = [both.create_task(_copy(viewer[0], behind[1])), both.create_task(_copy(behind[0], viewer[1]))]
                await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
                for way in ways:
                    way.cancel()
        except* TimeoutError as group:
            raise TimeoutError from group
        except* OSError:
            pass  # one of the two left
        finally:
            behind[1].transport.abort()


async def _copy(source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
    """Pass bytes on until the source ends.

    Raises:
        TimeoutError: The sink has not read for some seconds.
    """
    sink.transport.set_write_buffer_limits(_MOST_WAITING)
    while data := await source.read(_LARGEST_HEAD):
        sink.write(data)
        async with asyncio.timeout(_PATIENCE):
            await sink.drain()


async def _refuse(writer: asyncio.StreamWriter, status: HTTPStatus, text: str) -> None:
    body = text.encode()
    head = f"HTTP/1.1 {status.value} {status.phrase}\r\nContent-Length: {len(body)}\r\nConnection: close\r\n\r\n"
    writer.write(head.encode() + body)
    writer.write_eof()
    async with asyncio.timeout(_PATIENCE):
        await writer.drain()


_LIBRARY_LOG = logging.getLogger("foxglove.websocket")
_LIBRARY_LOG.setLevel(logging.CRITICAL)  # a line for each message that a closed viewer does not get


class FoxgloveServer:
    """Server for viewers, in threads of the library, behind a gate that checks who asks."""

    def __init__(self, host: str, port: int, allowed: Collection[str] = ()) -> None:
        """Start to serve.

        Args:
            host: Address to listen on.
            port: Port; 0 takes a free one.
            allowed: Names of this server besides those of this machine, and origins whose pages may ask.

        Raises:
            DrillTwinError: foxglove-sdk is not installed.
            RunError: The port is taken.
        """
        foxglove = _library()
        context = self._context = foxglove.Context()  # channels are closed once it is gone
        listener = listening_socket(host, port, "viewers", "--foxglove")
        # An address of this machine that no page guesses: only the gate asks there.
        inner = "127." + ".".join(str(1 + secrets.randbelow(254)) for _ in range(3))
        try:
            self._server = foxglove.start_server(
                name="drill_twin", host=inner, port=0, context=context, server_listener=self._listener()
            )
        except (OSError, RuntimeError) as error:
            listener.close()
            raise RunError(f"expected a free port at {inner}, found: {error}") from None
        self._channels = {
            topic: foxglove.Channel(
                topic, schema=_schema(foxglove, TOPICS[topic].type_name), message_encoding="cdr", context=context
            )
            for topic in TOPICS
        }
        self._latched: dict[str, tuple[bytes, int]] = {}
        self.url = f"ws://{in_url(host)}:{listener.getsockname()[1]}"
        """Address for viewers."""
        self._gate = ViewerGate(listener, (inner, self._server.port), allowed)

    def publish(self, topic: str, raw: bytes, time: int) -> None:
        """Pass a message on, with the time at which it was received [ns]."""
        if TOPICS[topic].latched:
            self._latched[topic] = (raw, time)
        self._channels[topic].log(raw, log_time=time)

    def _listener(self) -> Any:
        """Listener that sends the last message of a latched topic again when a viewer subscribes."""

        def on_subscribe(_client: Any, channel: Any) -> None:
            if channel.topic in self._latched:
                raw, time = self._latched[channel.topic]
                self._channels[channel.topic].log(raw, log_time=time)

        return SimpleNamespace(on_subscribe=on_subscribe, on_unsubscribe=lambda *_: None)

    def close(self) -> None:
        """End all connections."""
        self._gate.close()
        self._server.stop()


def _schema(foxglove: ModuleType, type_name: str) -> object:
    return foxglove.Schema(name=type_name, encoding="ros2msg", data=definition(type_name).encode())


def _library() -> ModuleType:
    try:
        import foxglove
    except ModuleNotFoundError as error:
        raise missing(error, "foxglove") from error
    library: ModuleType = foxglove
    return library
