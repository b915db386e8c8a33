# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin study validate`: records of rigs beside the twin."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli.options import JsonOption
from drill_twin_evidence.cli.output import OnlyOption, chosen

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from drill_twin.core.table import Table
    from drill_twin_evidence.validation import Validation


def validate(
    data: Annotated[
        Path | None,
        typer.Option(
            "--data", metavar="DIR", help="Folder with ufrj_rig/ or well_b/; that of DRILL_TWIN_DATA if left out."
        ),
    ] = None,
    only: OnlyOption = "",
    refit: Annotated[
        bool, typer.Option("--refit", help="Fit the numbers again instead of taking those of the scenes.")
    ] = False,
    page: Annotated[
        Path | None, typer.Option("--page", metavar="FILE", help="Write a page (.md) and its figures.")
    ] = None,
    blind: Annotated[
        Path | None,
        typer.Option(
            "--blind", metavar="DIR", help="Fit Well B at 1,714 m, predict its start-up at 2,235 m: CSV and figure."
        ),
    ] = None,
    json: JsonOption = False,
) -> None:
    """Print what was measured beside what is computed, and of each number whether it is a fit or a prediction."""
    from drill_twin.cli.emit import emit
    from drill_twin.cli.show import remark
    from drill_twin.core.errors import ArgumentError
    from drill_twin_evidence.validation import RECORDS, data_folder

    wanted = chosen(only, RECORDS)
    folder = data_folder(data)
    there = [name for name in wanted if (folder / name).is_dir()]
    if not there:
        raise ArgumentError(f"{folder}: expected a folder {' or '.join(wanted or RECORDS)}, found none; see --only")
    for name in set(wanted) - set(there):
        remark(f"{name}: left out, no folder {folder / name}")
    if blind is not None:
        _predict(folder / "well_b", blind)
        return
    found = [RECORDS[name](folder / name, refit=refit) for name in there]
    emit([one.to_dict() for one in found], _shown(found), json=json)
    if page is not None:
        _write(found, page)


def _shown(found: Sequence[Validation]) -> Iterator[Table | str]:
    from drill_twin_evidence.validation.page import table

    for one in found:
        yield table(one)
        yield one.about


def _write(found: Sequence[Validation], page: Path) -> None:
    from drill_twin.cli.emit import write_files
    from drill_twin_evidence.validation.page import figure, to_page

    write_files(page.parent, {page.name: to_page(found, page.stem)})
    write_files(page.parent / "figures", {f"{page.stem}_{one.record}.png": figure(one) for one in found})


def _predict(record: Path, folder: Path) -> None:
    from tempfile import TemporaryDirectory

    from drill_twin.api import load_scene
    from drill_twin.cli.emit import write_files
    from drill_twin_evidence.validation import blind_test, well_b

    with TemporaryDirectory() as place:
        found = well_b.fitted(record, load_scene("well_b", well_b.set_point(record, Path(place))))
        time, bands = blind_test.predict(record, found)
    files = {"well_b_2235.csv": blind_test.csv_text(time, bands), "well_b_2235.png": blind_test.figure(time, bands)}
    write_files(folder, files)
