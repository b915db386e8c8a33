# SPDX-License-Identifier: Apache-2.0
"""Commands `drill-twin export` and `drillbotics`: the rig's channels of a bag as CSV, LAS and competition files."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli.emit import check_new, say, write_file, write_files
from drill_twin.cli.options import (
    BagArgument,
    FromOption,
    NamespaceOption,
    RecordedArgument,
    ReplaceOption,
    ToOption,
    folder_option,
)
from drill_twin.cli.show import remark, shown_progress
from drill_twin.core.errors import ArgumentError, BagError
from drill_twin.core.table import Table


def export(
    bag: RecordedArgument,
    las: Annotated[bool, typer.Option("--las", help="Write LAS 2.0; needs the extra `las` of drill_twin.")] = False,
    csv: Annotated[bool, typer.Option("--csv", help="Write CSV.")] = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="The files, without ending.", show_default="rig, beside the report"),
    ] = None,
    begin: FromOption = -math.inf,
    end: ToOption = math.inf,
    namespace: NamespaceOption = "",
    replace: ReplaceOption = False,
) -> None:
    """Write weight on bit, hookload, torques and speeds of a bag over time, as CSV or LAS 2.0, in kN, kN.m and rpm."""
    from drill_twin.cli.analyze import default_folder
    from drill_twin.report.rig_table import csv_text, las_text, read_rig, rig_channels
    from drill_twin.report.selection import Selection

    if not (las or csv):
        raise ArgumentError("export: expected --las, --csv or both, found none")
    base = out or default_folder(bag) / "rig"
    if base.suffix in {".csv", ".las"}:
        base = base.with_suffix("")
    files = [base.with_name(f"{base.name}.{ending}") for ending, wanted in (("csv", csv), ("las", las)) if wanted]
    for file in files:
        check_new(file, replace=replace)
    with shown_progress("reading the bag"):
        rig, name = read_rig(bag, Selection(begin=begin, end=end, namespace=namespace or None))
    channels = rig_channels(rig)
    for file in files:
        write_file(file, csv_text(channels) if file.suffix == ".csv" else las_text(channels, name))
        print(file)
    remark(f"{len(rig)} samples; converted: N to kN, N m to kN.m, rad/s to rpm")


def drillbotics(
    bag: BagArgument,
    out: Annotated[Path | None, folder_option("Folder of the files.", "beside the report")] = None,
    well: Annotated[
        str, typer.Option("--well", metavar="NAME", help="Name of the well.", show_default="the scene's")
    ] = "",
    rate: Annotated[str, typer.Option("--rate", metavar="FREQUENCY", help="Rows per second, 1 Hz or more.")] = "10 Hz",
    start: Annotated[
        str,
        typer.Option("--start", metavar="TIME", help="Time zero in UTC, ISO 8601.", show_default="of the recording"),
    ] = "",
    begin: FromOption = -math.inf,
    end: ToOption = math.inf,
    namespace: NamespaceOption = "",
    replace: ReplaceOption = False,
) -> None:
    """Write drilling_timeseries.csv (D-WIS names) and WELL_logs.las of a bag, and check both against the rules.

    Needs the extra `las`. Exit code 1 where a rule is broken.
    """
    from drill_twin.api.scenes import in_si
    from drill_twin.cli.analyze import default_folder
    from drill_twin.core.files.yaml_reader import plain_yaml
    from drill_twin.core.units.dimension import FREQUENCY
    from drill_twin.gateway.drillbotics import LOWEST_RATE, TIMESERIES, check_log, check_timeseries, read_log
    from drill_twin.report.selection import Selection, open_bag

    rows = in_si("--rate", rate, FREQUENCY)
    if not LOWEST_RATE <= rows <= 1000.0:
        raise ArgumentError(f"--rate: expected {LOWEST_RATE:g} Hz, which the rules ask for, to 1000 Hz, found {rate}")
    folder = out or default_folder(bag)
    selection = Selection(begin=begin, end=end, namespace=namespace or None)
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
    if broken:
        raise typer.Exit(1)


def _date(text: str) -> datetime:
    try:
        found = datetime.fromisoformat(text)
    except ValueError:
        raise ArgumentError(f'--start: expected a time such as "2026-05-14T13:57:00Z", found "{text}"') from None
    return found if found.tzinfo else found.replace(tzinfo=UTC)
