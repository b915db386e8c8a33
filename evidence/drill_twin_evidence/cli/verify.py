# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin study verify`: every verification case, in one table."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import typer

from drill_twin.cli.options import JsonOption, WorkersOption
from drill_twin_evidence.cli.output import ListOption, OnlyOption, PageOption, QuickOption, check_any, told, write_page

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rich.text import Text

    from drill_twin.core.table import Table
    from drill_twin_evidence.verify import Case
    from drill_twin_evidence.verify.run import CaseResult

MISSED = 1
"""Exit code when a number is beyond its tolerance."""


def verify(
    only: OnlyOption = "",
    quick: QuickOption = False,
    names: ListOption = False,
    page: PageOption = None,
    workers: WorkersOption = 0,
    json: JsonOption = False,
) -> None:
    """Run the exact checks: buckling, frequencies, waves, contact, whirl and the like against closed forms.

    Ends with exit code 1 if a number misses its tolerance. The first run compiles a few kernels.
    """
    from drill_twin.cli.emit import emit
    from drill_twin.cli.show import remark
    from drill_twin_evidence.verify import choose
    from drill_twin_evidence.verify.page import summary, to_data, to_page
    from drill_twin_evidence.verify.run import run_cases

    cases = choose(only, quick=quick)
    check_any(cases, only, "verify")
    if names:
        _print_names(cases)
        return
    with told("verifying", len(cases), lambda one: (one.case.name, "" if one.ok else "miss")) as done:
        checks = run_cases(cases, workers=workers, progress=done)
    data = to_data(checks)
    emit(data, _shown(checks), json=json)
    remark(summary(checks))
    if page is not None:
        write_page(page, partial(to_page, checks), data, command="verify", only=only, flags={"--quick": quick})
    if not all(check.ok for check in checks):
        raise typer.Exit(MISSED)


def _print_names(cases: Sequence[Case]) -> None:
    from itertools import groupby

    from drill_twin.cli.emit import say
    from drill_twin.core.table import Table

    rows = []
    for name, group in groupby(cases, key=lambda case: case.name.partition("[")[0]):
        members = list(group)
        rows.append((name, len(members), members[0].about.split("\n\n")[0].replace("\n", " ")))
    say(Table(("case", "variants", "what it shows"), rows, right=(1,)))


def _shown(checks: Sequence[CaseResult]) -> Iterator[Table | Text]:
    from rich.text import Text

    from drill_twin.core.table import Column, Table
    from drill_twin_evidence.verify.page import computed, error, number, tolerance

    rows: list[tuple[object, ...]] = []
    for check in checks:
        rows.append((Text(check.case.name, style="bold"), *[""] * 5))
        said = ""
        for row in check.rows:
            reference = f"{row.reference} ({row.source})"
            told = Text(f"  {row.what}")
            if reference != said:
                told.append(f"\n    {reference}", style="dim")
            said = reference
            verdict = Text("ok") if row.ok else Text("MISS", style="red")
            rows.append((told, number(row.expected), computed(row), error(row), tolerance(row), verdict))
    numbers = (Column(name, right=True, whole=True) for name in ("expected", "computed", "error", "tolerance"))
    yield Table([Column("case, number and reference (source)"), *numbers, Column("", whole=True)], rows)
    for check in checks:
        if check.failure:
            yield Text(f"{check.case.name}: {check.failure}", "red")
