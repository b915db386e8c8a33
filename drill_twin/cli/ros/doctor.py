# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin doctor`: what is installed, who runs, what is wrong, what to do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from itertools import groupby
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import JsonOption

if TYPE_CHECKING:
    from rich.text import Text

    from drill_twin.core.table import Table
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
    from drill_twin.cli.emit import emit
    from drill_twin.cli.progress import shown_progress
    from drill_twin.ros.doctor.check import Verdict
    from drill_twin.ros.doctor.run import examine

    with shown_progress("checking"):
        checks = examine(seconds)
    problems = sum(check.verdict is Verdict.PROBLEM for check in checks)
    emit({"ok": not problems, "checks": [asdict(check) for check in checks]}, _shown(checks, problems), json=json)
    raise typer.Exit(1 if problems else 0)


def _shown(checks: list[Check], problems: int) -> Iterator[Table | Text | str]:
    """A table a section, with what to do below each check that found something."""
    from rich.text import Text

    from drill_twin.core.table import Column, Table
    from drill_twin.ros.doctor.check import Verdict

    styles = {Verdict.OK: "green", Verdict.NOTE: "yellow", Verdict.PROBLEM: "bold red"}
    for section, members in groupby(checks, key=lambda check: check.section):
        rows: list[tuple[object, ...]] = []
        for check in members:
            rows.append((Text(check.verdict.value, styles[check.verdict]), check.name, check.found))
            if check.remedy:
                rows.append(("", "", Text(f"-> {check.remedy}", styles[check.verdict])))
        yield Table([Column("", whole=True), Column(""), Column("")], rows, title=section)
    yield f"{problems} problem{'' if problems == 1 else 's'}" if problems else "nothing is wrong"
