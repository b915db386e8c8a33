# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin compare`: assemblies or set-points beside each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.emit import emit, new_folder
from drill_twin.cli.options import DurationOption, JsonOption, ReplaceOption, SetOption, UnitsOption, overrides
from drill_twin.cli.show import shown_progress
from drill_twin.core.errors import ArgumentError
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.api.compare import ComparedQuantity
    from drill_twin.core.units.system import UnitSystem


def compare(
    cases: Annotated[
        list[str],
        typer.Argument(
            metavar="CASE",
            help='Scenes, as "bha_full_size" or "bha_full_size,wob=120 kN,hole.radius=6 in", or bags; the first one is '
            "what the others are compared with.",
        ),
    ],
    duration: DurationOption = "",
    seeds: Annotated[
        int,
        typer.Option(
            "--seeds", metavar="N", min=1, max=100, help="Number of runs of a scene, a push and 1 % of its speed apart."
        ),
    ] = 3,
    change: SetOption = [],  # noqa: B006  typer makes a new list of it
    tolerance: Annotated[
        float, typer.Option("--tolerance", min=0.0, max=1.0, help="Share by which numbers must differ to be shown.")
    ] = 0.05,
    everything: Annotated[bool, typer.Option("--all", help="Show the numbers that do not differ, too.")] = False,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="New folder of the result.")] = Path("out/compare"),
    replace: ReplaceOption = False,
    units: UnitsOption = "",
    json: JsonOption = False,
) -> None:
    """Run two or more cases and show the differences that matter to a bit run, in a table and on a page.

    Loads and margins come from the balance of forces (`statics`), the rest from the second half of each run. The
    output ends with a verdict: what costs bits and joints, over runs of several seeds, and what the runs can show.
    Writes compare.html, compare.json and compare.png.
    """
    from drill_twin.api.compare import finish, page, prepare, quantities
    from drill_twin.api.verdict import again, cost_table, costs, verdicts
    from drill_twin.core.units.system import unit_system
    from drill_twin.report.comparison import draw_runs
    from drill_twin.report.figures.style import save

    if len(cases) < 2:
        raise ArgumentError(
            f"expected two cases or more, found {len(cases)}: name a second scene, or the same with changes"
        )
    common = overrides(change, duration=duration, units=units)
    prepared = [prepare(text, common) for text in cases]
    new_folder(out, replace=replace)
    found = []
    with shown_progress("computing", len(cases) * seeds, unit="runs") as bar:
        for text, what in zip(cases, prepared, strict=True):
            found.append(finish(text, what, lambda time, text=text: bar.show(f"{text}: {time:.1f} s")))  # type: ignore[misc]
            bar.step(text)
        repeated = [
            again(found, prepared, seed, lambda text, seed=seed: bar.step(f"{text}, seed {seed}"))  # type: ignore[misc]
            for seed in range(1, seeds)
        ]
    ranked = costs([found, *repeated], tolerance)
    rows, shown = quantities(found), unit_system(units or found[0].result.recording.units.name)
    notes = [
        f"{case.name}: its motion is irregular; a run that differs in anything shares its statistics, not its path."
        for case in found
        if case.result.summary["lasting_motion"] == "irregular"
    ]
    notes.append("The size of the safe window is not compared: drill-twin map SCENE computes it.")
    said, table = verdicts(ranked, shown), cost_table(ranked, shown)
    differing = [row for row in rows if row.differs(tolerance)]
    content = {
        "cases": cases, "tolerance": tolerance, "differing": [row.name for row in differing], "notes": notes,
        "verdict": said, "costs": [cost._asdict() for cost in ranked],
        "quantities": [{**row._asdict(), "differs": row.differs(tolerance)} for row in rows],
    }  # fmt: skip
    picture = draw_runs([(case.name, case.result.recording) for case in found], "Runs over time", units=shown)
    save(picture, out / "compare.png")  # the page holds it
    agree = f"{len(rows) - len(differing)} quantities agree to {100 * tolerance:g} %; --all shows them"
    emit(
        content, json=json,
        shown=chain(
            _shown(cases, *((rows, notes) if everything else (differing, [agree, *notes])), shown), [table, *said]
        ),
        folder=out,
        files={
            "compare.html": page(cases, rows, tolerance, notes, out / "compare.png", shown, said, table),
            "compare.json": content,
        },
        also=["compare.png"],
    )  # fmt: skip


def _shown(
    cases: Sequence[str], rows: Sequence[ComparedQuantity], notes: Sequence[str], units: UnitSystem
) -> Iterator[Table | str]:
    letters = [chr(ord("A") + number) for number in range(len(cases))]
    yield from (f"{letter}: {text}" for letter, text in zip(letters, cases, strict=True))
    if rows:
        cells = (
            (row.name, units.in_unit(row.unit)[1], *(row.text(k, units) for k in range(len(cases)))) for row in rows
        )
        yield Table(("", "", *letters), cells)
    yield from notes
