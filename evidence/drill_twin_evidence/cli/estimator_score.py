# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin study estimator-score`: the estimator on twins with hidden numbers."""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import Annotated, Any

import typer

from drill_twin.cli.options import JsonOption, time_option
from drill_twin_evidence.cli.output import OnlyOption, chosen

_SEEDS = 1_000_000
"""Seeds of truths, of which the first is drawn."""


def estimator_score(
    only: OnlyOption = "",
    truths: Annotated[int, typer.Option("--truths", min=1, help="Number of twins with hidden numbers.")] = 10,
    first: Annotated[
        int | None, typer.Option("--first", min=0, help="Number of the first one; drawn anew if left out.")
    ] = None,
    seconds: Annotated[float, time_option("--duration", "Simulated time for which each is followed", 2.0)] = 60.0,
    members: Annotated[
        list[int],
        typer.Option("--members", min=4, help="Number of members; repeatable, for error over members and time."),
    ] = [],  # noqa: B006
    imu: Annotated[bool, typer.Option("--imu", help="Measure with a downhole sub near the bit too.")] = False,
    journal: Annotated[
        Path | None, typer.Option("--journal", help="File of results; what is in it is not done again.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Measure the estimator on hidden truths: numbers, bands, unmeasured places, jumps, alarms, processor time.

    Prints the tables of docs/drill_twin_studies/bands.md.
    """
    from drill_twin.cli.show import print_json, remark
    from drill_twin.core.files.json_files import JsonLines
    from drill_twin_evidence.estimation.cases import CASES
    from drill_twin_evidence.estimation.hidden_truth import TruthRow, follow
    from drill_twin_evidence.estimation.score import cost_lines, lines, score

    names = chosen(only, CASES)
    file = None if journal is None else JsonLines(journal, TruthRow, "score", {"seconds": seconds, "imu": imu})
    rows = [] if file is None else file.results
    done = {(row["case"], row["members"], row["truth"]): row for row in rows}
    fresh = min((row["truth"] for row in rows), default=secrets.randbelow(_SEEDS))
    start = fresh if first is None else first
    found: dict[str, Any] = {}
    for name in names:
        by_members = {}
        for count in members or [CASES[name].members]:
            runs = []
            for number in range(start, start + truths):
                row = done.get((name, count, number))
                if row is None:
                    row = follow(CASES[name], number, seconds, count, imu=imu).row(name, count, number)
                    told = ", ".join(f"{key} {error:+.1%}" for key, error in row["errors"].items())
                    remark(f"{name} {number}, {count} members: {told}")
                    if file is not None:
                        file.add(row)
                runs.append(row)
            by_members[count] = score(runs)
        found[name] = by_members if len(by_members) > 1 else by_members[count]
        if not json:
            print("\n".join(cost_lines(name, by_members) if len(by_members) > 1 else lines(name, found[name])))
    if json:
        print_json(found)
