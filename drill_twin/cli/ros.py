# SPDX-License-Identifier: Apache-2.0
"""`drill-twin demo` and `topics`: the nodes, and what they say to each other."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from drill_twin.cli.options import JsonOption


def demo(context: typer.Context) -> None:
    """Run the paper's bench as ROS 2 nodes; see `drill-twin demo --help`. Needs rclpy."""
    from drill_twin.nodes.start import start

    raise typer.Exit(start("demo", context.args))


def topics(
    markdown: Annotated[bool, typer.Option("--markdown", help="Print the table as Markdown.")] = False,
    rig: Annotated[
        bool, typer.Option("--rig", help="Print the table of the rig guide: quality of service, stamps and frames.")
    ] = False,
    json: JsonOption = False,
) -> None:
    """List the topics of the nodes and of the bags: names, types, units."""
    from drill_twin.cli.show import grid, out, print_json
    from drill_twin.messages.topics import TOPICS, topic_table

    if json:
        print_json([asdict(topic) for topic in TOPICS.values()])
    elif rig:
        print(rig_table(), end="")
    elif markdown:
        print(topic_table(), end="")
    else:
        rows = (
            (topic.name, topic.type_name.replace("/msg/", "/"), f"{topic.publisher}, {topic.rate}", topic.meaning)
            for topic in TOPICS.values()
        )
        out().print(grid(("topic", "type", "who and when", "meaning"), rows))


def rig_table() -> str:
    """The contract as rig software needs it, in Markdown: who sends, how surely it arrives, what stamps it."""
    from drill_twin.messages.topics import CLOCK_TOPIC, FLOAT64, FRAME_ID, STRING, TOPICS

    unstamped = (FLOAT64, STRING)
    lines = [
        "| topic | type | from | rate | quality of service | stamp and frame |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for topic in TOPICS.values():
        latched = ", latched" if topic.latched or topic.name == CLOCK_TOPIC else ""
        stamp = "none" if topic.type_name in unstamped else f"simulated time, `{FRAME_ID}`"
        if topic.name == CLOCK_TOPIC:
            stamp = "simulated time"
        elif topic.publisher == "all nodes":
            stamp = "wall time"
        lines.append(
            f"| `{topic.name}` | {topic.type_name} | {topic.publisher} | {topic.rate} "
            f"| reliable, keep last {topic.depth}{latched} | {stamp} |"
        )
    return "\n".join(lines) + "\n"
