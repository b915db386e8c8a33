# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin study hard`: stress study on hard scenes."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import JsonOption, WorkersOption
from drill_twin_evidence.cli.output import ListOption, OnlyOption, PageOption, QuickOption, check_any, told, write_page

if TYPE_CHECKING:
    from drill_twin_evidence.verify.run import CaseResult

NOT_IN_ORDER = 1
"""Exit code when a case is not in order."""


def hard(
    only: OnlyOption = "",
    quick: QuickOption = False,
    exact: Annotated[
        bool, typer.Option("--exact", help="Run the exact checks of bounce, rolling, growth and stick-slip too.")
    ] = False,
    energy: Annotated[bool, typer.Option("--energy", help="Audit the energy; compiles further kernels.")] = False,
    names: ListOption = False,
    page: PageOption = None,
    region: Annotated[
        Path | None,
        typer.Option("--stability", metavar="FILE", help="Only draw stability over stiffness and damping (.png)."),
    ] = None,
    workers: WorkersOption = 0,
    json: JsonOption = False,
) -> None:
    """Run the hard scenes: loads far beyond buckling, jumps, hard walls, sticking, tiny and huge strings.

    Ends with exit code 1 if one is not in order. `drill-twin run hard/NAME` runs one of them as any other scene.
    """
    from drill_twin.cli.emit import emit, say
    from drill_twin.cli.show import remark
    from drill_twin.core.table import Table
    from drill_twin_evidence.stress import choose_hard, run_hard
    from drill_twin_evidence.stress.page import ALLOWED, COLUMNS, cells, summary, to_data, to_page

    if region is not None:
        _draw_map(region)
        return
    cases = choose_hard(only, quick=quick)
    check_any(cases, only, "hard")
    if names:
        reasons = {case.scene_name: case.why for case in cases}
        say(Table(("scene", "why it is hard"), reasons.items()))
        return
    with told("hard scenes", len(cases), lambda one: (one.name, "" if one.ok else one.verdict)) as done:
        results = run_hard(cases, workers=workers, energy=energy, progress=done)
    checks = _check(workers) if exact else []
    data = to_data(results, checks)
    lines = [[line[0].replace("_", " "), *line[1:ALLOWED], *line[ALLOWED + 1 :]] for line in map(cells, results)]
    table = Table((*COLUMNS[:ALLOWED], *COLUMNS[ALLOWED + 1 :]), lines, right=(2, 3, 4, 5, 6, 7))
    emit(data, [table, *(f"{one.name}: {one.verdict}" for one in results if one.verdict != "ok")], json=json)
    remark(summary(results))
    if page is not None:
        flags = {"--quick": quick, "--exact": exact, "--energy": energy}
        write_page(page, partial(to_page, results, checks), data, command="hard", only=only, flags=flags)
    if not (all(result.ok for result in results) and all(check.ok for check in checks)):
        raise typer.Exit(NOT_IN_ORDER)


def _draw_map(path: Path) -> None:
    from drill_twin.cli.show import remark, shown_progress
    from drill_twin_evidence.stability import draw, stability_map

    with shown_progress("half a minute of runs over step, stiffness of the wall and damping"):
        draw({what: stability_map(what) for what in ("wall", "damping_time")}, path)
    remark(f"{path}: see evidence/docs/random_scenes.md")


def _check(workers: int) -> list[CaseResult]:
    from drill_twin_evidence.stress.page import EXACT
    from drill_twin_evidence.verify import all_cases
    from drill_twin_evidence.verify.run import run_cases

    chosen = [case for case in all_cases() if case.name.partition("[")[0] in EXACT]
    return run_cases(chosen, workers=workers)
