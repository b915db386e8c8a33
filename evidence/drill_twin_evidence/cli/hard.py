# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin study hard`: stress study on hard scenes."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import JsonOption, WorkersOption
from drill_twin_evidence.cli.output import ListOption, OnlyOption, PageOption, QuickOption, write_page

if TYPE_CHECKING:
    from collections.abc import Sequence

    from drill_twin_evidence.stress import HardCase, Result
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
    from drill_twin.core.errors import SceneError
    from drill_twin.core.table import Table
    from drill_twin_evidence.stress import choose_hard
    from drill_twin_evidence.stress.page import ALLOWED, COLUMNS, cells, summary, to_data, to_page

    if region is not None:
        _draw_map(region)
        return
    cases = choose_hard(only, quick=quick)
    if not cases:
        raise SceneError(
            f'--only: expected a part of the name of a case, found "{only}"; see drill-twin study hard --list'
        )
    if names:
        reasons = {case.scene_name: case.why for case in cases}
        say(Table(("scene", "why it is hard"), reasons.items()))
        return
    results = _run(cases, workers, energy=energy)
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


def _run(cases: Sequence[HardCase], workers: int, *, energy: bool) -> list[Result]:
    from drill_twin.cli.show import remark, shown_progress
    from drill_twin_evidence.stress import run_hard

    with shown_progress("hard scenes", len(cases)) as bar:

        def done(result: Result) -> None:
            bar.step(result.name)
            if not result.ok:
                remark(f"{result.name}: {result.verdict}", "red")

        return run_hard(cases, workers=workers, energy=energy, progress=done)


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
