# SPDX-License-Identifier: Apache-2.0
"""Commands `drill-twin analyze`, `report` and `export`: analysis and report of a bag, and the rig's channels in it."""

from __future__ import annotations

import math
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import check_new, emit, write_file
from drill_twin.cli.show import findings_shown, marks_shown, remark, shown_progress
from drill_twin.core.companions import entry_of, not_installed
from drill_twin.core.errors import ArgumentError, BagError
from drill_twin.core.files.output import make_folder
from drill_twin.core.table import Table

if TYPE_CHECKING:
    from drill_twin.report import ReportFiles
    from drill_twin.report.recording import Recording

SUMMARY = "summary.json"
EXPORTS = "drill_twin.exports"
"""Entry-point group of files that other packages write from a bag."""


def analyze(
    bag: options.RecordedArgument,
    scene: options.SceneOption = "",
    out: Annotated[Path | None, options.folder_option("Write the result to this folder too, as summary.json.")] = None,
    replace: options.ReplaceOption = False,
    json: options.JsonOption = False,
    marks: Annotated[
        list[str], typer.Option("--marks", metavar="NAME", help="Analyse this mark only; repeatable, or NAME,NAME.")
    ] = [],  # noqa: B006  typer does not change the default
    begin: options.FromOption = -math.inf,
    end: options.ToOption = math.inf,
    topics: options.RemapOption = [],  # noqa: B006
    clearance: Annotated[
        str,
        typer.Option(
            "--clearance", metavar="LENGTH", help='Clearance of the marks, as "36 mm", for a bag without a scene.'
        ),
    ] = "",
    outer_radius: Annotated[
        str,
        typer.Option(
            "--rim",
            metavar="LENGTH",
            help="Outer radius of the string at the marks, for marks on its surface in a bag without a scene.",
        ),
    ] = "",
    namespace: options.NamespaceOption = "",
    why: Annotated[
        bool,
        typer.Option("--why", help="Say why it whirled or stuck, from modes and repeats of the run; takes minutes."),
    ] = False,
    sub: Annotated[
        str | None,
        typer.Option(
            "--sub",
            metavar="NAME",
            help="Analyse the readings of this downhole sub instead of the marks; for the sub of a rig, measured/NAME.",
        ),
    ] = None,
    units: options.UnitsOption = "",
    run: options.RunOption = 0,
    channel: options.ColumnOption = [],  # noqa: B006
    null: options.NullOption = [],  # noqa: B006
    everything: options.AllOption = False,
) -> None:
    """Find whirl in a bag, its onset, frequencies and motion states, and stick-slip of the bit.

    The analyzer node computes the same analysis; findings that it recorded live are compared byte for byte. A bag
    whose recorder was killed is read up to its last complete message.
    """
    from drill_twin.api.scenes import in_si
    from drill_twin.core.units.dimension import LENGTH
    from drill_twin.io.bag.reader import parse_remappings
    from drill_twin.io.bag.virtual_bags import RecordBag
    from drill_twin.report.summary import summarise

    if out is not None:
        make_folder(out)
        check_new(out / SUMMARY, replace=replace)
    if sub == "":
        raise BagError("--sub: expected a downhole sub, found no name; without --sub, marks are analysed")
    if sub and marks:
        raise BagError(f"--marks: expected no marks beside --sub, which is analysed, found {marks[0]}")
    with shown_progress("analysing the bag"):
        chosen = tuple(name.strip() for text in marks for name in text.split(",") if name.strip())
        room = in_si("--clearance", clearance, LENGTH) if clearance else None
        rim = in_si("--rim", outer_radius, LENGTH) if outer_radius else 0.0
        names = parse_remappings(topics, "--remap")
        recording = _recording(
            bag, scene, channel, null, namespace, marks=chosen, begin=begin, end=end, topics=names, clearance=room,
            outer_radius=rim, sub=sub or "", run=run, units=units,
        )  # fmt: skip
        if clearance and isinstance(recording.bag, RecordBag):
            remark("--clearance: no marks are read from a table; drill_twin.analyze or a bag takes them")
        summary = summarise(recording)
    if why:
        from drill_twin.api.cause import cause_of

        with shown_progress("modes", unit="repeats") as bar:
            cause = cause_of(recording, summary, progress=bar.show)
        summary["cause"] = cause.as_data()
    shown = chain(
        cause.shown() if why else (),
        findings_shown(summary, bag, everything=everything),
        marks_shown(summary) if everything else (),
    )
    emit(summary, shown, json=json, folder=out, files={SUMMARY: summary})


def report(
    bag: options.RecordedArgument,
    out: Annotated[Path | None, options.folder_option("Folder of the report.", "beside bag_0, or BAG_report")] = None,
    scene: options.SceneOption = "",
    replace: options.ReplaceOption = False,
    json: options.JsonOption = False,
    begin: options.FromOption = -math.inf,
    end: options.ToOption = math.inf,
    namespace: options.NamespaceOption = "",
    units: options.UnitsOption = "",
    run: options.RunOption = 0,
    channel: options.ColumnOption = [],  # noqa: B006
    null: options.NullOption = [],  # noqa: B006
) -> None:
    """Draw the report of a bag: report.html, which needs no network, and its figures as PNG."""
    folder = out or default_folder(bag)
    check_new(folder / "report.html", replace=replace)
    with shown_progress("analysing the bag"):
        recording = _recording(bag, scene, channel, null, namespace, begin=begin, end=end, run=run, units=units)
    files = draw(recording, folder)
    figures = {name: str(path) for name, path in files.figures.items()}
    data = {"report": str(files.page), "summary": str(files.summary), "figures": figures}
    emit(data, [*files.verdict, *([Table((), files.answers)] if files.answers else []), str(files.page)], json=json)


def draw(recording: Recording, folder: Path) -> ReportFiles:
    """Build the report, with a status line that names the part in progress."""
    from drill_twin.report import build_report

    with shown_progress("drawing") as bar:
        return build_report(recording, folder, progress=lambda part: bar.show(f"drawing: {part}"))


def default_folder(bag: Path) -> Path:
    """Default folder of a report: `out/run/bag_0` -> `out/run`; any other `x` -> `x_report` beside it."""
    from drill_twin.io.bag.reading.files import bag_path
    from drill_twin.io.bag.virtual_bags import is_record

    found = bag_path(bag).absolute()
    if (found.suffix in {".mcap", ".db3"} and found.is_file()) or is_record(found):
        found = found.parent if found.parent.name == "bag_0" else found.with_suffix("")
    return found.parent if found.name == "bag_0" else found.with_name(f"{found.name}_report")


def _recording(
    bag: Path, scene: str, channels: list[str], nulls: list[str], namespace: str, **selected: Any
) -> Recording:
    """Analyse the selected part of a bag or record; says how the columns of a record were read."""
    from drill_twin.io.bag.virtual_bags import RecordBag
    from drill_twin.report.recording import read_recording
    from drill_twin.report.selection import Selection
    from drill_twin.scene import load_scene

    selection = Selection(namespace=namespace or None, choices=options.choices(channels, nulls), **selected)
    found = read_recording(bag, load_scene(scene) if scene else None, selection)
    if isinstance(found.bag, RecordBag):
        remark(found.bag.read)
        if pairs := [choice.replace("=", ": '", 1) + "'" for choice in selection.choices]:
            remark(f"for all commands: write {found.path.name}.yaml beside it, a line each: {', '.join(pairs)}")
    return found


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
    rerun: Annotated[
        bool,
        typer.Option(
            "--rerun",
            help="Write run.rrd, to be seen in the viewer rerun: string, orbits, trends; needs the extra `rerun`.",
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
    channel: options.ColumnOption = [],  # noqa: B006
    null: options.NullOption = [],  # noqa: B006
) -> None:
    """Write a bag for other programs: the rig's channels as CSV or LAS, in kN, kN.m and rpm, or all for a viewer."""
    from drill_twin.report.selection import Selection

    if not (las or csv or drillbotics or rerun):
        raise ArgumentError("export: expected --csv, --las, --drillbotics, --rerun or several, found none")
    folder = out or default_folder(bag)
    selection = Selection(begin=begin, end=end, namespace=namespace or None, choices=options.choices(channel, null))
    if files := [folder / f"rig.{ending}" for ending, wanted in (("csv", csv), ("las", las)) if wanted]:
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
    others: list[tuple[str, str, tuple[str, ...]]] = [
        ("drillbotics", "drill_twin_rig", (well, rate, start))
    ] * drillbotics
    for name, package, given in others + [("rerun", "drill_twin_dashboard", ())] * rerun:
        if (written := entry_of(EXPORTS, name)) is None:
            raise not_installed(f"`drill-twin export --{name}`", package)
        if written.load()(bag, selection, folder, *given, replace=replace) is False:  # rules are broken
            raise typer.Exit(1)
