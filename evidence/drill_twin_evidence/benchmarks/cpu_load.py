# SPDX-License-Identifier: Apache-2.0
"""Processor load and memory of every node of a twin that runs in real time over DDS.

    python -m drill_twin_evidence.benchmarks.cpu_load --elements 16 --rate 100

The nodes are processes of their own, as on a rig, without other subscribers. Their processor time is the operating
system's (user and system, including all DDS threads), from `/proc`.
"""

from __future__ import annotations

import os
import resource
import tempfile
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli.emit import emit
from drill_twin.cli.options import JsonOption, time_option
from drill_twin.cli.show import shown_progress
from drill_twin.core.table import Table
from drill_twin.io.messages.diagnostics import Status
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin_evidence.benchmarks.processes import Child, processes, twin_commands

_WARM_UP = 2.0  # s of simulated time after which everything has been used once


@dataclass(frozen=True)
class LoadOptions:
    """Scene and duration of the measurement."""

    scene: str = "pa6_bench"
    """Scene: preset or path."""
    rate: float = 200.0
    """Frames a second [Hz]."""
    elements: int = 50
    """Elements of the string."""
    seconds: float = 20.0
    """Duration of the measurement [s]."""


@dataclass(frozen=True)
class NodeLoad:
    """Load of one node."""

    node: str
    """Name of the node."""
    processor: float
    """Share of one core [-]."""
    memory: int
    """Resident memory [bytes]."""


def run_load(options: LoadOptions) -> tuple[list[NodeLoad], Mapping[str, str]]:
    """Start the nodes, measure their load, and end them.

    Returns:
        Load of each node, and the diagnostic values of the simulator.

    Raises:
        DrillTwinError: They do not start, or (RunError) do not end well.
    """
    from drill_twin.ros.deployment import own_domain

    overrides = f"numerics.elements={options.elements}; numerics.frame_rate={options.rate:g} Hz"
    scene = {"scene": options.scene, "overrides": overrides}
    with (
        tempfile.TemporaryDirectory(prefix="drill_twin_load_") as folder,
        own_domain(Path(folder)),
        processes(twin_commands({}, scene, Path(folder, "bag_0")), dict(os.environ), Path(folder)) as children,
    ):
        _observe(children, _WARM_UP)
        shares = _measure(children, options.seconds)
        return shares, _observe(children, 0.0)


def _observe(children: Mapping[str, Child], until: float) -> Mapping[str, str]:
    """Diagnostic values of the simulator after a simulated time [s]; they come from a node that is gone afterwards.

    Raises:
        RunError: A process has ended with an error.
    """
    # Imported after the children were started: DDS threads do not survive a fork.
    from drill_twin.io.messages.topics import DIAGNOSTICS
    from drill_twin.ros.core.node import TwinNode
    from drill_twin.ros.core.node_main import init_context

    said: dict[str, str] = {}

    class Observer(TwinNode):
        NAME = "load"
        PURPOSE = "Listens to the simulator."

    def take(found: tuple[int, list[Status]]) -> None:
        for status in found[1]:
            if float(status.values.get("simulated_time", "nan")) > until:
                said.update(status.values)

    context = init_context([], StopRequest())
    try:
        observer = Observer(context)
        observer.topics.subscribe(DIAGNOSTICS, take)
        try:
            while not said:
                observer.spin_once(0.1)
                for child in children.values():
                    child.check_alive()
        finally:
            observer.close()  # its executor first: one that outlives its context ends in a segmentation fault
    finally:
        context.try_shutdown()
    return said


def processor_time(pid: int) -> float:
    """User and system time of a process [s], all threads included."""
    fields = Path(f"/proc/{pid}/stat").read_text("utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / float(os.sysconf("SC_CLK_TCK"))


def _measure(children: Mapping[str, Child], seconds: float) -> list[NodeLoad]:
    begun = time.monotonic()
    before = {node: processor_time(child.pid) for node, child in children.items()}
    while (left := begun + seconds - time.monotonic()) > 0.0:
        time.sleep(min(left, 0.2))
    passed = time.monotonic() - begun
    return [
        NodeLoad(node, (processor_time(child.pid) - before[node]) / passed, _memory(child.pid))
        for node, child in children.items()
    ]


def _memory(pid: int) -> int:
    return int(Path(f"/proc/{pid}/statm").read_text("utf-8").split()[1]) * resource.getpagesize()


def load(
    scene: Annotated[str, typer.Argument(help="Name of an installed scene, or a scene file.")] = "pa6_bench",
    rate: Annotated[
        float, typer.Option("--rate", metavar="HZ", help="Frames per second.", min=1.0, max=1000.0)
    ] = 200.0,
    elements: Annotated[
        int, typer.Option("--elements", help="Number of elements of the string.", min=2, max=2000)
    ] = 50,
    seconds: Annotated[float, time_option("--duration", "Length of the measurement", 1.0, 3600.0)] = 20.0,
    json: JsonOption = False,
) -> None:
    """Measure the share of a processor core that each node takes in real time. Needs ROS 2 (rclpy).

    Simulator, rig driver, analyzer and recorder run as processes over DDS; their processor time is that of the kernel,
    with all threads of DDS. The simulator itself measures its time for the motion and for publishing.
    """
    with shown_progress("running the nodes"):
        shares, said = run_load(LoadOptions(scene, rate, elements, seconds))
    rows = [(share.node, f"{share.processor:.1%}", f"{share.memory / 2**20:.0f} MB") for share in shares]
    physics, publishing = 1.0 / float(said["physics_speed"]), float(said["publishing_share"])
    emit(
        {"nodes": [asdict(share) for share in shares], "simulator": dict(said)},
        [
            Table(("node", "of one core", "memory"), rows, right=(1, 2)),
            f"of the simulator: {physics:.1%} the motion, {publishing:.1%} encoding and publishing",
        ],
        json=json,
    )


if __name__ == "__main__":
    typer.run(load)
