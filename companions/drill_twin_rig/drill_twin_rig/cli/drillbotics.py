# SPDX-License-Identifier: Apache-2.0
"""Files of the Drillbotics competition, for `drill-twin export --drillbotics`."""

import re
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

from drill_twin.api.scenes import in_si
from drill_twin.cli.emit import check_new, say, write_files
from drill_twin.cli.show import shown_progress
from drill_twin.core.errors import ArgumentError, BagError
from drill_twin.core.files.yaml_reader import plain_yaml
from drill_twin.core.table import Table
from drill_twin.core.units.dimension import FREQUENCY
from drill_twin.report.selection import Selection, open_bag
from drill_twin_rig.gateway.drillbotics import LOWEST_RATE, TIMESERIES, check_log, check_timeseries, read_log


def competition(
    bag: Path, selection: Selection, folder: Path, well: str, rate: str, start: str, *, replace: bool
) -> bool:
    """Write the files of the competition and print how they fare by its rules; returns whether none is broken."""
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
