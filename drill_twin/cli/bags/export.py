# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin export`: the rig's channels of a bag as CSV and LAS."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from drill_twin.cli.options import FromOption, NamespaceOption, RecordedArgument, ReplaceOption, ToOption
from drill_twin.core.errors import ArgumentError


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
    from drill_twin.cli.bags.analyze import default_folder
    from drill_twin.cli.folder import check_new, write_file
    from drill_twin.cli.progress import shown_progress
    from drill_twin.cli.show import remark
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
