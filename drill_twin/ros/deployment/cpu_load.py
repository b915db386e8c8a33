# SPDX-License-Identifier: Apache-2.0
"""What running the twin takes: the share of a processor core and the memory of every node, in real time over DDS.

The nodes are processes of their own, as on a rig, with nobody else listening. Their processor time is the kernel's
(user and system, all threads of DDS included), from `/proc`.
"""

from __future__ import annotations

import os
import resource
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drill_twin.errors import RunError
from drill_twin.ros.core.stop_request import StopRequest
from drill_twin.ros.deployment.processes import processes

_STARTING = 150.0  # s to compile and connect
_SETTLED = 2.0  # s of simulated time after which everything has been used once


@dataclass(frozen=True)
class LoadOptions:
    """What is measured."""

    scene: str = "pa6_bench"
    """Scene: preset or path."""
    rate: float = 200.0
    """Frames a second [Hz]."""
    elements: int = 50
    """Elements of the string."""
    seconds: float = 20.0
    """How long it is measured [s]."""


@dataclass(frozen=True)
class Share:
    """What one node takes."""

    node: str
    """Name of the node."""
    processor: float
    """Share of one core."""
    memory: int
    """Resident memory [bytes]."""


def run_load(options: LoadOptions, stop: StopRequest) -> tuple[list[Share], Mapping[str, str]]:
    """Start the nodes, measure them, end them.

    Returns:
        What each node takes, and what the simulator says about itself.

    Raises:
        DrillTwinError: They do not start, or (RunError) do not end well.
    """
    from drill_twin.ros.deployment.discovery import DomainClaim, domain_of_environment, prepare

    claim = DomainClaim(domain_of_environment())
    os.environ["ROS_DOMAIN_ID"] = str(claim.domain)
    prepare()
    try:
        with tempfile.TemporaryDirectory(prefix="drill_twin_load_") as folder:
            os.environ["ROS_LOG_DIR"] = folder
            with processes(_commands(options, Path(folder)), dict(os.environ), Path(folder)) as children:
                _watch(children, stop, lambda watcher: watcher.time > _SETTLED)
                shares = _measure(children, options.seconds, stop)
                return shares, _watch(children, stop, lambda watcher: bool(watcher.simulator))
    finally:
        claim.release()


def _commands(options: LoadOptions, folder: Path) -> dict[str, Mapping[str, object]]:
    overrides = f"numerics.elements={options.elements}; numerics.frame_rate={options.rate:g} Hz"
    scene = {"scene": options.scene, "overrides": overrides}
    return {
        "simulator": scene,
        "rig_driver": {**scene, "wait_for": "simulator analyzer recorder", "wait_timeout": _STARTING},
        "analyzer": {},
        "recorder": {"bag": str(folder / "bag_0")},
    }


def _watch(children: Mapping[str, Any], stop: StopRequest, enough: Any) -> Mapping[str, str]:
    """Look on until something has been seen; the looker itself costs the simulator a reader, so it goes again."""
    # Imported after the children were started: a fork must not meet the threads of DDS.
    from drill_twin.ros.core.node_main import init_context
    from drill_twin.ros.demo.demo_observer import DemoObserver

    context = init_context([], stop)
    end = time.monotonic() + _STARTING
    try:
        watcher = DemoObserver(context, lambda _: None)
        while not stop and not enough(watcher):
            watcher.spin_once(0.1)
            for child in children.values():
                child.check_alive()
            if time.monotonic() > end:
                raise RunError(f"the twin stood at {watcher.time:g} s for {_STARTING:g} s; drill-twin demo shows more")
        watcher.destroy_node()
        return watcher.simulator
    finally:
        context.try_shutdown()


def _measure(children: Mapping[str, Any], seconds: float, stop: StopRequest) -> list[Share]:
    begun = time.monotonic()
    before = {node: _processor_time(child.pid) for node, child in children.items()}
    while not stop and (left := begun + seconds - time.monotonic()) > 0.0:
        time.sleep(min(left, 0.2))
    passed = time.monotonic() - begun
    return [
        Share(node, (_processor_time(child.pid) - before[node]) / passed, _memory(child.pid))
        for node, child in children.items()
    ]


def _processor_time(pid: int) -> float:
    """User and system time of a process [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text("utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / float(os.sysconf("SC_CLK_TCK"))


def _memory(pid: int) -> int:
    return int(Path(f"/proc/{pid}/statm").read_text("utf-8").split()[1]) * resource.getpagesize()
