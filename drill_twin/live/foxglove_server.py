# SPDX-License-Identifier: Apache-2.0
"""Topics over the Foxglove protocol (`foxglove.sdk.v1`), for Foxglove and other viewers that speak it; reading only."""

from __future__ import annotations

import logging
import secrets
from collections.abc import Collection
from types import ModuleType, SimpleNamespace
from typing import Any

from drill_twin.core.errors import RunError, missing
from drill_twin.core.loopback import in_url
from drill_twin.io.messages.topics import TOPICS
from drill_twin.io.messages.type_store import definition
from drill_twin.live.server import listening_socket
from drill_twin.live.viewer_gate import ViewerGate

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
