# SPDX-License-Identifier: Apache-2.0
"""The port for viewers: who may ask, how many, and what waits for a viewer that does not read."""

import json
import struct
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from browser import get
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from drill_twin.core.errors import RunError
from drill_twin.io.messages.topics import RIG_STATE, imu_topic
from drill_twin_dashboard.live.foxglove_server import MOST_VIEWERS, FoxgloveServer

DATA = struct.Struct("<BIQ")  # operation, subscription, time [ns]


@pytest.fixture
def server():
    opened = FoxgloveServer("127.0.0.1", 0, ["app.foxglove.dev", "file://"])
    opened.offer(RIG_STATE)
    yield opened
    opened.close()


def _connected(server, **more):
    return connect(server.url, subprotocols=["foxglove.sdk.v1"], max_size=None, **more)


def _subscribed(socket):
    """Subscribe to the state of the rig."""
    channels = {}
    while RIG_STATE not in channels:
        channels |= {one["topic"]: one["id"] for one in json.loads(socket.recv(timeout=10.0)).get("channels", [])}
    socket.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": channels[RIG_STATE]}]}))


@contextmanager
def _refused(status):
    with pytest.raises(InvalidStatus) as caught:
        yield
    assert caught.value.response.status_code == status


def test_a_viewer_is_told_of_a_topic_that_comes_later(server):
    """As of a simulator whose scene has a sub, which is started after the viewer."""
    with _connected(server) as socket:
        told = [json.loads(socket.recv(timeout=10.0)) for _ in range(2)]
        assert [one["topic"] for one in told[1]["channels"]] == [RIG_STATE]
        server.offer(imu_topic("low"))
        (channel,) = json.loads(socket.recv(timeout=10.0))["channels"]
    assert (channel["topic"], channel["schemaName"]) == (imu_topic("low"), "sensor_msgs/msg/Imu")
    assert channel["id"] != told[1]["channels"][0]["id"]


@pytest.mark.parametrize("origin", [None, "https://app.foxglove.dev", "file://", "own"])
def test_an_allowed_viewer_gets_messages(server, origin):
    own = server.url.replace("ws", "http")
    with _connected(server, origin=own if origin == "own" else origin) as socket:
        _subscribed(socket)
        end = time.monotonic() + 10.0
        while True:
            assert time.monotonic() < end
            server.publish(RIG_STATE, b"payload", 5)
            try:
                data = socket.recv(timeout=0.1)
            except TimeoutError:
                continue
            if isinstance(data, bytes):
                break
    assert DATA.unpack_from(data) == (1, 7, 5)
    assert data[DATA.size :] == b"payload"


def test_a_page_of_another_origin_or_name_is_refused(server):
    with _refused(403), _connected(server, origin="https://elsewhere.example"):
        pass
    place = server.url.removeprefix("ws://")
    for origin in ("http://[::", "null", "https://app.foxglove.dev.elsewhere.example", "https://a@[b", ""):
        assert get(place, "/", Origin=origin)[0] == 403
    assert get(place, "/", Host="elsewhere.example:80")[0] == 403
    assert get(place, "/", Host="a/b")[0] == 400


def test_viewers_are_counted(server):
    with ExitStack() as opened:
        for _ in range(MOST_VIEWERS):
            opened.enter_context(_connected(server))
        with _refused(503), _connected(server):
            pass
    end = time.monotonic() + 20.0
    while True:  # the places are free again
        try:
            with _connected(server):
                break
        except InvalidStatus:
            assert time.monotonic() < end


def _resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def test_little_waits_for_viewers_that_do_not_read(server, caplog):
    with ExitStack() as opened:
        for _ in range(MOST_VIEWERS):
            _subscribed(opened.enter_context(_connected(server, max_queue=1, close_timeout=0.1)))
        _flood(server, caplog)
        began = time.monotonic()
        server.close()
        assert time.monotonic() - began < 10.0


def _flood(server, caplog):
    """Publish until the first viewer is closed."""
    before, raw = _resident(), bytes(100_000)
    end = time.monotonic() + 40.0
    while not any("did not read" in record.message for record in caplog.records):
        assert time.monotonic() < end
        server.publish(RIG_STATE, raw, 5)  # 16 viewers: 32 MB a second
        time.sleep(0.05)
    assert _resident() - before < 150e6


def test_a_port_that_is_taken_is_told(server):
    port = int(server.url.rpartition(":")[2])
    with pytest.raises(RunError, match=f"free port for viewers, found 127.0.0.1:{port}: .*--foxglove"):
        FoxgloveServer("127.0.0.1", port)
