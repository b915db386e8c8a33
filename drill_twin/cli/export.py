# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin export`: the rig's channels of a bag as CSV, LAS and files of the Drillbotics competition."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import check_new, say, write_file, write_files
from drill_twin.cli.show import remark, shown_progress
from drill_twin.core.errors import ArgumentError, BagError
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.report.selection import Selection


def export(
    bag: options.RecordedArgument,
    csv: Annotated[bool, typer.Option("--csv", help="Write rig.csv, with units in its heading.")] = False,
    las: Annotated[bool, typer.Option("--las", help="Write rig.las (LAS 2.0); needs the extra `las`.")] = False,
    drillbotics: Annotated[
        bool,
        typer.Option(
            "--drillbotics",
            help="Write drilling_timeseries.csv and WELL_logs.las for the Drillbotics competition, and check both by "
            "its rules; exit code 1 if one is broken. Needs the extra `las`.",
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
) -> None:
    """Write weight on bit, hookload, torques and speeds of a bag over time as CSV or LAS, in kN, kN.m and rpm."""
    from drill_twin.cli.analyze import default_folder
    from drill_twin.report.selection import Selection

    if not (las or csv or drillbotics):
        raise ArgumentError("export: expected --csv, --las, --drillbotics or several, found none")
    folder = out or default_folder(bag)
    selection = Selection(begin=begin, end=end, namespace=namespace or None)
    if files := [folder / f"rig.{ending}" for ending, wanted in (("csv", csv), ("las", las)) if wanted]:
        _series(bag, selection, files, replace=replace)
    if drillbotics and not _competition(bag, selection, folder, well, rate, start, replace=replace):
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


def _competition(
    bag: Path, selection: Selection, folder: Path, well: str, rate: str, start: str, *, replace: bool
) -> bool:
    """Write the files of the competition and print how they fare by its rules; returns whether none is broken."""
    from drill_twin.api.scenes import in_si
    from drill_twin.core.files.yaml_reader import plain_yaml
    from drill_twin.core.units.dimension import FREQUENCY
    from drill_twin.gateway.drillbotics import LOWEST_RATE, TIMESERIES, check_log, check_timeseries, read_log
    from drill_twin.report.selection import open_bag

    rows = in_si("--rate", rate, FREQUENCY)
    if not LOWEST_RATE <= rows <= 1000.0:
        raise ArgumentError(f"--rate: expected {LOWEST_RATE:g} Hz, which the rules ask for, to 1000 Hz, found {rate}")
    with shown_progress("reading the bag"):
        source = open_bag(bag, selection)
        log = read_log(source, selection, rows, _date(start) if start else None)
    name = well
    if not well:
        with suppress(BagError):
            name = str(plain_yaml(source.scene()).get("name") or "")
    name = name or "well"
    timeseries, logs = folder / TIMESERIES, folder / f"{re.sub(r'[^A-Za-z0-9-]+', '_', name)}_logs.las"
    for file in (timeseries, logs):
        check_new(file, replace=replace)
    write_files(folder, {timeseries.name: log.csv_text(), logs.name: log.las_text(name)})
    verdict, broken = {True: "passed", False: "broken", None: "note"}, False
    for file, check in ((timeseries, check_timeseries), (logs, check_log)):
        rules = list(check(file))
        broken |= any(passed is False for _, passed, _ in rules)
        lines = [(rule, verdict[passed], told) for rule, passed, told in rules]
        say(Table(("rule", "", "found"), lines, title=file.name))
    print(timeseries, logs, sep="\n")
    return not broken


def _date(text: str) -> datetime:
    try:
        found = datetime.fromisoformat(text)
    except ValueError:
        raise ArgumentError(f'--start: expected a time such as "2026-05-14T13:57:00Z", found "{text}"') from None
    return found if found.tzinfo else found.replace(tzinfo=UTC)
