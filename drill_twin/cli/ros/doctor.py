# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin doctor`: what is installed, who runs, what is wrong, what to do."""

from __future__ import annotations

from dataclasses import asdict
from itertools import groupby
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import JsonOption

if TYPE_CHECKING:
    from drill_twin.ros.doctor.check import Check


def doctor(
    seconds: Annotated[
        float,
        typer.Option(
            "--seconds", metavar="SECONDS", help="How long to listen to the nodes; 0: not.", min=0.0, max=600.0
        ),
    ] = 4.0,
    json: JsonOption = False,
) -> None:
    """Check the installation and the running nodes: versions, topics, quality of service, clocks; says what to do.

    Works without ROS too, and says so; the nodes of ROS_DOMAIN_ID are checked where rclpy is there. Exit code 1 when
    something is wrong.
    """
    from drill_twin.cli.show import err, print_json
    from drill_twin.ros.doctor.check import Verdict
    from drill_twin.ros.doctor.run import examine

    with err().status("checking"):
        checks = examine(seconds)
    problems = [check for check in checks if check.verdict is Verdict.PROBLEM]
    if json:
        print_json({"ok": not problems, "checks": [asdict(check) for check in checks]})
    else:
        show(checks)
    raise typer.Exit(1 if problems else 0)


def show(checks: list[Check]) -> None:
    """Print the checks as a table a section, and what to do below."""
    from rich.table import Table
    from rich.text import Text

    from drill_twin.cli.show import out
    from drill_twin.ros.doctor.check import Verdict

    styles = {Verdict.OK: "green", Verdict.NOTE: "yellow", Verdict.PROBLEM: "bold red"}
    console = out()
    for section, members in groupby(checks, key=lambda check: check.section):
        table = Table(
            title=section, title_justify="left", title_style="bold", show_header=False, box=None, pad_edge=False
        )
        table.add_column(no_wrap=True)
        table.add_column(overflow="fold", max_width=28)
        table.add_column(overflow="fold")
        for check in members:
            table.add_row(Text(check.verdict.value, styles[check.verdict]), Text(check.name), Text(check.found))
            if check.remedy:
                table.add_row("", "", Text(f"-> {check.remedy}", styles[check.verdict]))
        console.print(table)
        console.print()
    count = sum(check.verdict is Verdict.PROBLEM for check in checks)
    console.print(f"{count} problem{'' if count == 1 else 's'}" if count else "nothing is wrong")
