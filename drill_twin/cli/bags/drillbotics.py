# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin drillbotics`: the two files of the Drillbotics competition, checked against its rules."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli.options import BagArgument, FromOption, NamespaceOption, ReplaceOption, ToOption
from drill_twin.core.errors import ArgumentError, BagError


def drillbotics(
    bag: BagArgument,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Folder of the files.", show_default="beside the report")
    ] = None,
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
    from drill_twin.cli.bags.analyze import default_folder
    from drill_twin.cli.emit import say, write_files
    from drill_twin.cli.folder import check_new
    from drill_twin.cli.progress import shown_progress
    from drill_twin.core.files.yaml_reader import plain_yaml
    from drill_twin.core.table import Table
    from drill_twin.core.units import UnitError, parse
    from drill_twin.core.units.dimension import FREQUENCY
    from drill_twin.gateway.drillbotics import LOWEST_RATE, TIMESERIES, check_log, check_timeseries, read_log
    from drill_twin.report.selection import Selection, open_bag

    try:
        rows = parse(rate, FREQUENCY)
    except UnitError as error:
        raise ArgumentError(f"--rate: {error}") from None
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
