# SPDX-License-Identifier: Apache-2.0
"""Load and latency of the gateway; needs rclpy and asyncua.

    python -m drill_twin_evidence.benchmarks.gateway [SECONDS]

A twin whirls in real time; a client, a process of its own, subscribes to 20 signals at 10 Hz, has control and writes a
target five times a second. Printed are the share of a core that the gateway takes with and without clients, by the
kernel's account, and the time from the begin of a write to the command's arrival at a subscriber of `/rig/command`.
"""

from __future__ import annotations

import asyncio
import json
import os
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from drill_twin_evidence.benchmarks.cpu_load import processor_time

SIGNALS = 20
_PERIOD, _WRITE_PERIOD = 100, 0.2  # ms, s
_USER = "bench"
_PASSWORD = "bench and bench"  # noqa: S105 - of this benchmark only


def main(seconds: float = 20.0) -> None:
    """Measure, and print the result."""
    from drill_twin.ros.deployment import own_domain
    from drill_twin_evidence.benchmarks.processes import processes
    from drill_twin_rig.gateway.opc_ua.keys import CERTIFICATE, TRUSTED, make_keys

    with tempfile.TemporaryDirectory() as name, own_domain(Path(name)), socket.socket() as free:
        folder = Path(name)
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
        free.close()
        make_keys(folder, "urn:drill_twin:gateway", "localhost", {_USER: _PASSWORD})
        (folder / TRUSTED / "own.der").write_bytes((folder / CERTIFICATE).read_bytes())
        gateway = {"port": port, "keys": str(folder), "grant": "always"}
        nodes = {"simulator": {}, "analyzer": {}, "gateway": gateway}
        with processes(nodes, dict(os.environ), folder) as children:
            _measure(children["gateway"].pid, f"opc.tcp://127.0.0.1:{port}/drill_twin", folder, seconds)


def _measure(gateway: int, url: str, folder: Path, seconds: float) -> None:
    from rclpy.experimental.events_executor import EventsExecutor
    from rclpy.node import Node
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64

    from drill_twin.io.messages.decode import JointStateReader
    from drill_twin.ros.core.node_main import init_context
    from drill_twin.ros.core.stop_request import StopRequest

    context = init_context([], StopRequest())
    node = Node("bench", context=context)
    arrived: dict[float, float] = {}
    taken = EventsExecutor(context=context)
    taken.add_node(node)
    reader = JointStateReader()

    def on_command(raw: bytes) -> None:
        arrived.setdefault(float(reader.read(bytes(raw)).effort[1]), time.monotonic())

    node.create_subscription(JointState, "rig/command", on_command, 100, raw=True)
    for topic, value in (("rig/wob_command", 40.0), ("rig/rps_command", 2.0)):
        publisher = node.create_publisher(Float64, topic, 10)
        deadline = time.monotonic() + 60.0
        while not publisher.get_subscription_count() and time.monotonic() < deadline:
            taken.spin_once(0.1)
        publisher.publish(Float64(data=value))
    time.sleep(2.0)
    alone = core_share(gateway, seconds, taken.spin_once)
    client = subprocess.Popen(
        [sys.executable, "-m", "drill_twin_evidence.benchmarks.gateway", "client", url, str(folder),
         str(seconds + 4.0)],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    end = time.monotonic() + 3.0
    while time.monotonic() < end:
        taken.spin_once(0.1)
    with_client = core_share(gateway, seconds, taken.spin_once)
    while client.poll() is None:
        taken.spin_once(0.05)
    found = json.loads(client.communicate()[0])
    context.try_shutdown()
    latencies = sorted(1e3 * (arrived[value] - begun) for value, begun in found["writes"] if value in arrived)
    trips = sorted(1e3 * trip for trip in found["trips"])
    print(f"gateway without clients: {alone:.1%} of a core")
    print(f"gateway, a client with {SIGNALS} signals at 10 Hz, encrypted: {with_client:.1%} of a core")
    print(f"changes sent: {found['changes']:.0f} a second")
    for text, values in (("write to /rig/command", latencies), ("write, answered", trips)):
        if values:
            late = values[int(0.95 * len(values))]
            print(f"{text}: median {statistics.median(values):.2f} ms, 95 % {late:.2f} ms, of {len(values)}")


def core_share(pid: int, seconds: float, turn: Callable[[float], object] = time.sleep) -> float:
    """Share of a core that a process takes over a time [s]; `turn` passes a tenth of a second of it."""
    begun, before = time.monotonic(), processor_time(pid)
    while time.monotonic() - begun < seconds:
        turn(0.1)
    return (processor_time(pid) - before) / (time.monotonic() - begun)


class _Counter:
    changes = 0

    def datachange_notification(self, *_: object) -> None:
        """Count a change."""
        self.changes += 1


async def _client(url: str, folder: Path, seconds: float) -> None:
    from asyncua import Client, ua
    from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256

    client, counter = Client(url), _Counter()
    client.application_uri = "urn:drill_twin:gateway"
    client.set_user(_USER)
    client.set_password(_PASSWORD)
    keys = (str(folder / "certificate.der"), str(folder / "private_key.pem"))
    await client.set_security(SecurityPolicyBasic256Sha256, *keys, None, str(folder / "certificate.der"))
    async with client:
        space = (await client.get_namespace_array()).index("urn:drill_twin:gateway")
        nodes = (await client.get_node(ua.NodeId("Signals", space)).get_children())[:SIGNALS]
        subscription = await client.create_subscription(_PERIOD, counter)
        await subscription.subscribe_data_change(nodes)
        target, beat = (client.get_node(ua.NodeId(name, space)) for name in ("WOBTarget", "Heartbeat"))
        await client.get_node(ua.NodeId("Request", space)).write_value(True)
        await asyncio.sleep(1.0)
        writes, trips = [], []
        begun, counter.changes = time.monotonic(), 0
        number = 0
        while time.monotonic() - begun < seconds:
            number += 1
            await beat.write_value(ua.Variant(number, ua.VariantType.UInt32))
            value, start = 40.0 + 1e-3 * number, time.monotonic()
            await target.write_value(value)
            trips.append(time.monotonic() - start)
            writes.append((value, start))
            await asyncio.sleep(_WRITE_PERIOD)
    rate = counter.changes / (time.monotonic() - begun)
    print(json.dumps({"writes": writes, "trips": trips, "changes": rate}))


if __name__ == "__main__":
    if sys.argv[1:2] == ["client"]:
        asyncio.run(_client(sys.argv[2], Path(sys.argv[3]), float(sys.argv[4])))
    else:
        main(*map(float, sys.argv[1:]))
