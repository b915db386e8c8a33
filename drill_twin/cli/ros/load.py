# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin load`: processor time of each node."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from drill_twin.cli.options import JsonOption


def load(
    scene: Annotated[str, typer.Argument(help="Preset or scene file.")] = "pa6_bench",
    rate: Annotated[float, typer.Option("--rate", metavar="HZ", help="Frame rate.", min=1.0, max=1000.0)] = 200.0,
    elements: Annotated[int, typer.Option("--elements", help="Elements of the string.", min=2, max=2000)] = 50,
    seconds: Annotated[
        float, typer.Option("--seconds", metavar="SECONDS", help="Length of the measurement.", min=1.0, max=3600.0)
    ] = 20.0,
    json: JsonOption = False,
) -> None:
    """Measure the share of a processor core that each node takes in real time. Needs ROS 2 (rclpy).

    Simulator, rig driver, analyzer and recorder run as processes over DDS; their processor time is that of the kernel,
    with all threads of DDS. The simulator itself measures its time for the motion and for publishing.
    """
    from drill_twin.cli.emit import emit
    from drill_twin.cli.progress import shown_progress
    from drill_twin.core.table import Table
    from drill_twin.ros.demo.cpu_load import LoadOptions, run_load

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
