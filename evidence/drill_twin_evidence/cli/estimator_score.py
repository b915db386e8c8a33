# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin estimator-score`: the estimator on twins with hidden numbers."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from drill_twin.cli.options import JsonOption


def estimator_score(
    only: Annotated[list[str], typer.Option("--only", metavar="CASE", help="Case; repeatable. All if left out.")] = [],  # noqa: B006
    truths: Annotated[int, typer.Option("--truths", min=1, help="Twins with hidden numbers.")] = 10,
    first: Annotated[int, typer.Option("--first", min=0, help="Number of the first one.")] = 0,
    seconds: Annotated[float, typer.Option("--seconds", min=2.0, help="Time to follow each.")] = 60.0,
    members: Annotated[
        list[int], typer.Option("--members", min=4, help="Members; repeatable: error against members and time.")
    ] = [],  # noqa: B006
    imu: Annotated[bool, typer.Option("--imu", help="Measure with a downhole sub near the bit too.")] = False,
    json: JsonOption = False,
) -> None:
    """Measure the estimator on hidden truths: numbers, bands, unmeasured places, warnings of whirl, processor time.

    Prints the tables of docs/estimator.md.
    """
    from drill_twin.cli.show import print_json, remark
    from drill_twin.core.errors import ArgumentError
    from drill_twin_evidence.estimation.hidden_truth import CASES, follow
    from drill_twin_evidence.estimation.score import cost_lines, lines, score

    odd = [name for name in only if name not in CASES]
    if odd:
        raise ArgumentError(f"--only: expected one of {', '.join(CASES)}, found {', '.join(odd)}")
    found: dict[str, Any] = {}
    for name in only or CASES:
        by_members = {}
        for count in members or [CASES[name].members]:
            runs = []
            for number in range(first, first + truths):
                runs.append(follow(CASES[name], number, seconds, count, imu=imu))
                told = ", ".join(f"{key} {error:+.1%}" for key, error in runs[-1].errors.items())
                remark(f"{name} {number}, {count} members: {told}")
            by_members[count] = score(runs)
        found[name] = by_members if len(by_members) > 1 else by_members[count]
        if not json:
            print("\n".join(cost_lines(name, by_members) if len(by_members) > 1 else lines(name, found[name])))
    if json:
        print_json(found)
