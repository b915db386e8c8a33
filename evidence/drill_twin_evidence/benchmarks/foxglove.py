# SPDX-License-Identifier: Apache-2.0
"""Load of a viewer on `drill-twin watch --foxglove`.

    python -m drill_twin_evidence.benchmarks.foxglove [SECONDS]

A twin runs in real time at 200 frames a second; a client of the Foxglove protocol, in this process, subscribes to all
topics. Printed is the share of a core that the page's process takes without a client and with one.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from drill_twin_evidence.benchmarks.gateway import core_share

_PROTOCOL = Subprotocol("foxglove.sdk.v1")


def main(seconds: float = 15.0) -> None:
    """Measure, and print the result."""
    from drill_twin.ros.demo.processes import processes
    from drill_twin.ros.deployment import own_domain

    rate = {"overrides": "numerics.frame_rate=200 Hz"}
    nodes = {"analyzer": {}, "simulator": rate, "rig_driver": rate}
    with (
        tempfile.TemporaryDirectory() as name,
        own_domain(Path(name)),
        processes(nodes, dict(os.environ), Path(name)),
    ):
        words = [sys.executable, "-m", "drill_twin.cli", "watch", "--no-browser", "--port", "0", "--foxglove", "0"]
        page = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        try:
            lines = iter(page.stdout.readline, "") if page.stdout else iter(())
            url = next(found[1] for line in lines if (found := re.search(r"for Foxglove: (\S+)", line)))
            time.sleep(20.0)
            alone = core_share(page.pid, seconds)
            received, socket = _subscribe(url)
            time.sleep(1.0)
            begun, before = time.monotonic(), received[0]
            with_client = core_share(page.pid, seconds)
            frames = (received[0] - before) / (time.monotonic() - begun)
            socket.close()
            print(f"without a client {alone:.1%}, with one {with_client:.1%} of a core")
            print(f"messages to the client: {frames:.0f} a second")
        finally:
            page.terminate()
            page.wait()


def _subscribe(url: str) -> tuple[list[int], ClientConnection]:
    """Subscribe to all topics; returns the count of messages, which grows, and the connection."""
    opened = connect(url, subprotocols=[_PROTOCOL], max_size=None)
    socket, received = ExitStack().enter_context(opened), [0]
    channels: list[dict[str, Any]] = []
    while not channels:
        channels = json.loads(socket.recv()).get("channels", [])
    asked = [{"id": one["id"], "channelId": one["id"]} for one in channels]
    socket.send(json.dumps({"op": "subscribe", "subscriptions": asked}))

    def count() -> None:
        try:
            for _ in socket:
                received[0] += 1
        except ConnectionClosed:
            return

    threading.Thread(target=count, daemon=True).start()
    return received, socket


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
