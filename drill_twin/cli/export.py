# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin export`: the rig's channels of a bag as CSV, LAS and files of the Drillbotics competition."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import check_new, write_file
from drill_twin.cli.show import remark, shown_progress
from drill_twin.core.companions import entry_of, not_installed
from drill_twin.core.errors import ArgumentError

if TYPE_CHECKING:
    from drill_twin.report.selection import Selection

EXPORTS = "drill_twin.exports"
"""Entry-point group of files that other packages write from a bag."""


def export(
    bag: options.RecordedArgument,
    csv: Annotated[bool, typer.Option("--csv", help="Write rig.csv, with units in its heading.")] = False,
    las: Annotated[bool, typer.Option("--las", help="Write rig.las (LAS 2.0); needs the extra `las`.")] = False,
    drillbotics: Annotated[
        bool,
        typer.Option(
            "--drillbotics",
            help="Write drilling_timeseries.csv and WELL_logs.las for the Drillbotics competition, and check both by "
            "its rules; exit code 1 if one is broken. Needs the package drill_twin_rig.",
        ),
    ] = False,
    well: Annotated[
        str,
        typer.Option(
            "--well", metavar="NAME", help="With --drillbotics: name of the well.", show_default="the scene's"
        ),
    ] = "",
    rate: Annotated[
        str, typer.Option("--rate", metavar="FREQUENCY", help="With --drillbotics: rows per second, 1 Hz or more.")
    ] = "10 Hz",
    start: Annotated[
        str,
        typer.Option(
            "--start",
            metavar="DATE",
            help="With --drillbotics: date and time of time 0 in UTC, ISO 8601.",
            show_default="of the recording",
        ),
    ] = "",
    out: Annotated[Path | None, options.folder_option("Folder of the files.", "beside the report")] = None,
    begin: options.FromOption = -math.inf,
    end: options.ToOption = math.inf,
    namespace: options.NamespaceOption = "",
    replace: options.ReplaceOption = False,
    channel: options.ColumnOption = [],  # noqa: B006  typer makes a new list of it
    null: options.NullOption = [],  # noqa: B006
) -> None:
    """Write weight on bit, hookload, torques and speeds of a bag over time as CSV or LAS, in kN, kN.m and rpm."""
    from drill_twin.cli.analyze import default_folder
    from drill_twin.report.selection import Selection

    if not (las or csv or drillbotics):
        raise ArgumentError("export: expected --csv, --las, --drillbotics or several, found none")
    folder = out or default_folder(bag)
    columns = options.choices(channel, null)
    selection = Selection(begin=begin, end=end, namespace=namespace or None, choices=columns)
    if files := [folder / f"rig.{ending}" for ending, wanted in (("csv", csv), ("las", las)) if wanted]:
        _series(bag, selection, files, replace=replace)
    if drillbotics:
        competition = entry_of(EXPORTS, "drillbotics")
        if competition is None:
            raise not_installed("`drill-twin export --drillbotics`", "drill_twin_rig")
        if not competition.load()(bag, selection, folder, well, rate, start, replace=replace):
            raise typer.Exit(1)


def _series(bag: Path, selection: Selection, files: Sequence[Path], *, replace: bool) -> None:
    """Write the channels of the rig."""
    from drill_twin.report.rig_table import csv_text, las_text, read_rig, rig_channels

    for file in files:
        check_new(file, replace=replace)
    with shown_progress("reading the bag"):
        rig, name = read_rig(bag, selection)
    channels = rig_channels(rig)
    for file in files:
        write_file(file, csv_text(channels) if file.suffix == ".csv" else las_text(channels, name))
        print(file)
    remark(f"{len(rig)} samples; converted: N to kN, N m to kN.m, rad/s to rpm")
