# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin verify`: every verification case, in one table."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import JsonOption, WorkersOption

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from drill_twin_evidence.verify import Case
    from drill_twin_evidence.verify.run import CaseResult

MISSED = 1
"""Exit code when a number is beyond its tolerance."""


def verify(
    only: Annotated[
        str,
        typer.Option(
            "--only", metavar="PATTERN", help='Cases whose name contains this, or matches it, as "buckling.*lateral]".'
        ),
    ] = "",
    quick: Annotated[
        bool, typer.Option("--quick", help="Leave out the cases that take more than a few seconds.")
    ] = False,
    names: Annotated[bool, typer.Option("--list", help="Print the names of the cases and their descriptions.")] = False,
    page: Annotated[
        Path | None,
        typer.Option("--page", metavar="FILE", help="Write the table as a page (.md), and as JSON beside it."),
    ] = None,
    workers: WorkersOption = 2,
    json: JsonOption = False,
) -> None:
    """Run the exact checks: buckling, frequencies, waves, contact, whirl and the like against closed forms.

    Ends with exit code 1 if a number misses its tolerance. The first run compiles a few kernels.
    """
    from drill_twin.core.errors import SceneError
    from drill_twin_evidence.cli.output import write_page
    from drill_twin_evidence.verify import choose
    from drill_twin_evidence.verify.page import to_data, to_page

    cases = choose(only, quick=quick)
    if not cases:
        raise SceneError(f'--only: expected a part of the name of a case, found "{only}"; see drill-twin verify --list')
    if names:
        _print_names(cases)
        return
    checks = _run(cases, workers)
    _show(checks, json=json)
    if page is not None:
        data, flags = to_data(checks), {"--quick": quick}
        write_page(page, partial(to_page, checks), data, command="verify", only=only, flags=flags)
    if not all(check.ok for check in checks):
        raise typer.Exit(MISSED)


def _print_names(cases: Sequence[Case]) -> None:
    from itertools import groupby

    from drill_twin.cli.show import grid, out

    rows = []
    for name, group in groupby(cases, key=lambda case: case.name.partition("[")[0]):
        members = list(group)
        rows.append((name, str(len(members)), members[0].about.split("\n\n")[0].replace("\n", " ")))
    out().print(grid(("case", "variants", "what it shows"), rows, right=(1,)))


def _run(cases: Sequence[Case], workers: int) -> list[CaseResult]:
    from drill_twin_evidence.cli.output import counting_bar
    from drill_twin_evidence.verify.run import run_cases

    progress, task = counting_bar("verifying", len(cases))
    with progress:

        def done(check: CaseResult) -> None:
            progress.update(task, advance=1, description=check.case.name)
            if not check.ok:
                progress.console.print(f"miss: {check.case.name}", style="red", markup=False)

        return run_cases(cases, workers=workers, progress=done)


def _show(checks: Sequence[CaseResult], *, json: bool) -> None:
    from drill_twin.cli.show import err, out, print_json
    from drill_twin_evidence.verify.page import summary, to_data

    if json:
        print_json(to_data(checks))
    else:
        out().print(_table(checks))
        for check in checks:
            if check.failure:
                out().print(f"{check.case.name}: {check.failure}", style="red", markup=False, soft_wrap=True)
    err().print(summary(checks), markup=False, soft_wrap=True)


def _table(checks: Sequence[CaseResult]) -> Table:
    from rich.text import Text

    from drill_twin.cli.show import grid
    from drill_twin_evidence.verify.page import computed, error, number, tolerance

    table = grid(("case, number and reference (source)", "expected", "computed", "error", "tolerance", ""), (),
                 right=(1, 2, 3, 4))  # fmt: skip
    for column in table.columns[1:]:
        column.no_wrap = True
    for check in checks:
        table.add_row(Text(check.case.name, style="bold"))
        said = ""
        for row in check.rows:
            reference = f"{row.reference} ({row.source})"
            told = Text(f"  {row.what}")
            if reference != said:
                told.append(f"\n    {reference}", style="dim")
            said = reference
            cells = (number(row.expected), computed(row), error(row), tolerance(row))
            verdict = Text("ok") if row.ok else Text("MISS", style="red")
            table.add_row(told, *map(Text, cells), verdict)
    return table
