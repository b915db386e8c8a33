# SPDX-License-Identifier: Apache-2.0
"""Commands `drill-twin replay` and `drill-twin ros ...`: nodes and topics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from itertools import groupby
from json import dumps
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.emit import emit
from drill_twin.cli.options import BagArgument, JsonOption, NamespaceOption, RemapOption, time_option
from drill_twin.cli.show import shown_progress
from drill_twin.core.table import Column, Table

if TYPE_CHECKING:
    from rich.text import Text

    from drill_twin.ros.doctor.installation import Check


def node(
    context: typer.Context,
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            help="simulator, rig_driver, analyzer, recorder, advisor, estimator, gateway, replayer, or twin (several "
            "in one process). All that follows is the node's: --help, or --ros-args with parameters and remappings.",
        ),
    ],
) -> None:
    """Run one node, as `ros2 run drill_twin NAME` does where ros2 is installed. Needs ROS 2 (rclpy)."""
    from drill_twin.ros.entry_points import start

    raise typer.Exit(start(name, context.args))


def demo(context: typer.Context) -> None:
    """Run a scene as ROS 2 nodes, record it and draw the report; --help shows the options. Needs ROS 2 (rclpy)."""
    from drill_twin.ros.entry_points import start

    raise typer.Exit(start("demo", context.args))


def replay(
    bag: BagArgument,
    rate: Annotated[
        float,
        typer.Option(
            "--rate",
            metavar="NUMBER",
            help="Speed of the replay over the recorded speed; 0: as fast as possible.",
            min=0.0,
            max=1000.0,
        ),
    ] = 1.0,
    names: RemapOption = [],  # noqa: B006  typer does not change the default
    leave_out: Annotated[
        list[str], typer.Option("--leave-out", metavar="TOPIC", help="Do not publish this topic; repeatable.")
    ] = [],  # noqa: B006
    wait_for: Annotated[
        list[str], typer.Option("--wait-for", metavar="NODE", help="Start when this node is ready; repeatable.")
    ] = [],  # noqa: B006
    loop: Annotated[bool, typer.Option("--loop", help="Start again at the end.")] = False,
    offset: Annotated[float, time_option("--start-offset", "Begin this long after the start of the bag")] = 0.0,
    namespace: NamespaceOption = "",
) -> None:
    """Publish a bag again over DDS, with /clock, at any rate: the replayer node. Needs ROS 2 (rclpy).

    Topics have their recorded names, with the namespace that they were recorded in.
    """
    from drill_twin.ros.entry_points import start

    given = {
        "bag": str(bag), "rate": rate, "loop": loop, "map": " ".join(names), "leave_out": " ".join(leave_out),
        "wait_for": " ".join(wait_for), "twin": namespace, "start_offset": offset,
    }  # fmt: skip
    arguments = [argument for name, value in given.items() for argument in ("-p", f"{name}:={dumps(value)}")]
    raise typer.Exit(start("replayer", ["--ros-args", *arguments]))


def topics(json: JsonOption = False) -> None:
    """List the topics of the nodes and of the bags: names, types, units."""
    from drill_twin.io.messages.topics import OF_SUBS, TOPICS

    topics = (*TOPICS.values(), *OF_SUBS)
    rows = (
        (topic.name, topic.type_name.replace("/msg/", "/"), f"{topic.publisher}, {topic.rate}", topic.meaning)
        for topic in topics
    )
    shown = Table(("topic", "type", "publisher, rate", "meaning"), rows)
    emit([asdict(topic) for topic in topics], [shown], json=json)


def doctor(
    seconds: Annotated[
        float, time_option("--duration", "Time for which it listens to the nodes (0 s: not at all)", 0.0, 600.0)
    ] = 4.0,
    json: JsonOption = False,
) -> None:
    """Check the installation and the running nodes, and say what to do: versions, topics, quality of service, clocks.

    It works without ROS too. With rclpy it listens to the nodes in ROS_DOMAIN_ID. Exit code 1 when something is
    wrong.
    """
    from drill_twin.ros.doctor import examine
    from drill_twin.ros.doctor.installation import Verdict

    with shown_progress("checking"):
        checks = examine(seconds)
    problems = sum(check.verdict is Verdict.PROBLEM for check in checks)
    emit({"ok": not problems, "checks": [asdict(check) for check in checks]}, _shown(checks, problems), json=json)
    raise typer.Exit(1 if problems else 0)


def _shown(checks: list[Check], problems: int) -> Iterator[Table | Text | str]:
    """A table a section, with what to do below each check that found something."""
    from rich.text import Text

    from drill_twin.ros.doctor.installation import Verdict

    styles = {Verdict.OK: "green", Verdict.NOTE: "yellow", Verdict.PROBLEM: "bold red"}
    for section, members in groupby(checks, key=lambda check: check.section):
        rows: list[tuple[object, ...]] = []
        for check in members:
            rows.append((Text(check.verdict.value, styles[check.verdict]), check.name, check.found))
            if check.remedy:
                rows.append(("", "", Text(f"-> {check.remedy}", styles[check.verdict])))
        yield Table([Column("", whole=True), "", Column("", broken=True)], rows, title=section)
    yield f"{problems} problem{'' if problems == 1 else 's'}" if problems else "nothing is wrong"
