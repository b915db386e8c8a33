# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin study paper`: reproduction of the paper."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from drill_twin.cli.options import JsonOption, ReplaceOption, WorkersOption

BENCH = "pa6_calibrated"
RESULT = ("paper.json", "paper.md")


def paper(
    scene: Annotated[str, typer.Option("--scene", metavar="SCENE", help="The bench, by name or file.")] = BENCH,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder of the result.")] = Path("out/paper"),
    workers: WorkersOption = 0,
    quick: Annotated[
        bool, typer.Option("--quick", help="Only the matrix of the bench: no variants, no full-size assembly.")
    ] = False,
    replace: ReplaceOption = False,
    json: JsonOption = False,
) -> None:
    """Run all cases of the paper and print each published number beside that of the twin: tables, figures, one page."""
    from drill_twin.cli.emit import check_new, emit
    from drill_twin.cli.show import shown_progress
    from drill_twin_evidence.paper.pages.figures import draw
    from drill_twin_evidence.paper.pages.tables import lead, page, tables
    from drill_twin_evidence.paper.runs.reproduction import bench, reproduce

    described = bench(scene)
    for name in RESULT:
        check_new(out / name, replace=replace)
    with shown_progress("the paper's runs", unit="runs") as bar:
        done = reproduce(described, processes=workers, variants=not quick, full_size_too=not quick, progress=bar.show)
    figures = draw(done)
    files: dict[str, Any] = {f"{name}.png": figure for name, figure in figures.items()}
    files |= dict(zip(RESULT, (done.to_dict(), page(done, figures)), strict=True))
    emit(done.to_dict(), (lead(done), *tables(done)), json=json, folder=out, files=files)
