# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin compare`: assemblies or set-points beside each other."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli.options import JsonOption, ReplaceOption, SetOption, overrides
from drill_twin.core.errors import ArgumentError


def compare(
    cases: Annotated[
        list[str],
        typer.Argument(
            metavar="A B ...",
            help='Scenes, as "bha_full_size" or "bha_full_size,wob=120 kN,hole.radius=6 in", or bags; the first one is '
            "what the others are compared with.",
        ),
    ],
    duration: Annotated[
        str, typer.Option("--duration", metavar="TIME", help='Simulated time, as "30 s"; a bare number is in s.')
    ] = "",
    change: SetOption = [],  # noqa: B006  typer makes a new list of it
    tolerance: Annotated[
        float, typer.Option("--tolerance", min=0.0, max=1.0, help="Share from which numbers differ.")
    ] = 0.05,
    everything: Annotated[bool, typer.Option("--all", help="Show what does not differ too.")] = False,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="New folder of the result.")] = Path("out/compare"),
    replace: ReplaceOption = False,
    json: JsonOption = False,
) -> None:
    """Run two or more cases and show the differences that matter to a bit run, in a table and on a page.

    Loads and margins come from the balance of forces (`statics`), the rest from the second half of each run. Writes
    compare.html, compare.json and compare.png.
    """
    from drill_twin.api.compare.case import finish, prepare
    from drill_twin.api.compare.page import page
    from drill_twin.api.compare.quantities import quantities
    from drill_twin.cli.folder import new_folder, write_file
    from drill_twin.cli.show import err, grid, print_json
    from drill_twin.cli.show import out as stdout
    from drill_twin.report.comparison import draw_runs
    from drill_twin.report.figures.style import save
    from drill_twin.studies.json_io import json_text

    if len(cases) < 2:
        raise ArgumentError(
            f"expected two cases or more, found {len(cases)}: name a second scene, or the same with changes"
        )
    common = overrides(change, duration=duration)
    prepared = [prepare(text, common) for text in cases]
    new_folder(out, replace=replace)
    found = []
    with err().status("computing") as status:
        for text, what in zip(cases, prepared, strict=True):
            found.append(finish(text, what, lambda time, text=text: status.update(f"{text}: {time:.1f} s")))  # type: ignore[misc]
    rows = quantities(found)
    notes = [
        f"{case.name}: its motion is irregular; a run that differs in anything shares its statistics, not its path."
        for case in found
        if case.result.summary["lasting_motion"] == "irregular"
    ]
    differing = [row for row in rows if row.differs(tolerance)]
    content = {
        "cases": cases, "tolerance": tolerance, "differing": [row.name for row in differing], "notes": notes,
        "quantities": [{**row._asdict(), "differs": row.differs(tolerance)} for row in rows],
    }  # fmt: skip
    write_file(out / "compare.json", json_text(content))
    save(draw_runs([(case.name, case.result.recording) for case in found], "Runs over time"), out / "compare.png")
    write_file(out / "compare.html", page(cases, rows, tolerance, notes, out / "compare.png"))
    if json:
        print_json(content)
    else:
        shown = rows if everything else differing
        letters = [chr(ord("A") + number) for number in range(len(cases))]
        for letter, text in zip(letters, cases, strict=True):
            stdout().print(f"{letter}: {text}", markup=False, soft_wrap=True)
        columns = ("", "", *letters)
        table = [(row.name, row.shown_unit, *(row.text(k) for k in range(len(cases)))) for row in shown]
        if table:
            stdout().print(grid(columns, table))
        if not everything:
            same = len(rows) - len(differing)
            stdout().print(f"{same} quantities agree to {100 * tolerance:g} %; --all shows them", markup=False)
        for note in notes:
            stdout().print(note, markup=False, soft_wrap=True)
    err().print(f"{out}: compare.html, compare.json, compare.png", markup=False, soft_wrap=True)
