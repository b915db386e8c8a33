# SPDX-License-Identifier: Apache-2.0
"""Topics over the Foxglove protocol (`foxglove.sdk.v1`), for Foxglove and other viewers that speak it; reading only."""

from __future__ import annotations

from types import ModuleType, SimpleNamespace
from typing import Any

from drill_twin.errors import DrillTwinError, RunError
from drill_twin.io.messages.topics import TOPICS
from drill_twin.io.messages.type_store import definition


class FoxgloveServer:
    """Server for viewers, in threads of the library."""

    def __init__(self, host: str, port: int) -> None:
        """Start to serve.

        Args:
            host: Address to listen on.
            port: Port; 0 takes a free one.

        Raises:
            DrillTwinError: foxglove-sdk is not installed.
            RunError: The port is taken.
        """
        foxglove = _library()
        context = self._context = foxglove.Context()  # channels are closed once it is gone
        try:
            self._server = foxglove.start_server(
                name="drill_twin", host=host, port=port, context=context, server_listener=self._listener()
            )
        except (OSError, RuntimeError) as error:
            raise RunError(f"expected a free port at ws://{host}:{port}, found: {error}") from None
        self._channels = {
            topic: foxglove.Channel(
                topic, schema=_schema(foxglove, TOPICS[topic].type_name), message_encoding="cdr", context=context
            )
            for topic in TOPICS
        }
        self._latched: dict[str, tuple[bytes, int]] = {}
        self.url = f"ws://{host}:{self._server.port}"
        """Address for viewers."""

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
        self._server.stop()


def _schema(foxglove: ModuleType, type_name: str) -> object:
    return foxglove.Schema(name=type_name, encoding="ros2msg", data=definition(type_name).encode())


def _library() -> ModuleType:
    try:
        import foxglove
    except ModuleNotFoundError as error:
        raise DrillTwinError(
            f"expected the Python module {error.name!r}, found none; pip install 'drill_twin[foxglove]'"
        ) from error
    library: ModuleType = foxglove
    return library
