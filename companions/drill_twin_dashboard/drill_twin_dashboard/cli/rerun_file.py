# SPDX-License-Identifier: Apache-2.0
"""Recording for the viewer rerun (rerun.io), for `drill-twin export --rerun`.

The timeline `time` has the stamps of the run. Entities are `well/...` (hole, string and marks [m]
to north, east and down, lateral distances enlarged by a factor), `orbits/...` (centre line at each
mark, x and y off the axis of the hole, seen from above), `trends/...` and `events`; units are the scene's.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin.cli.emit import check_new, write_file
from drill_twin.cli.show import remark, shown_progress
from drill_twin.core.errors import import_extra
from drill_twin.io.findings_encoder import UNKNOWN
from drill_twin.io.messages.decode import JointStateReader
from drill_twin.io.messages.drawing.geometry import ExaggeratedGeometry, default_exaggeration
from drill_twin.io.messages.topics import TWIN_SUMMARY
from drill_twin.io.scene_geometry import string_geometry
from drill_twin.physics.model.survey import top_frame
from drill_twin.report.figures.over_time import rig_panels
from drill_twin.report.recording import Recording, read_recording
from drill_twin.report.selection import Selection
from drill_twin.report.string_curve import arc_of, smooth
from drill_twin.report.summary import summarise
from drill_twin.report.text import onset_text
from drill_twin.report.verdict import verdict

GREY, LIGHT, BLUE, ORANGE = (118, 118, 118), (217, 217, 217), (0, 114, 178), (230, 159, 0)
"""Colours of the report's figures: red, green and blue."""
RINGS, SEGMENTS = 25, 8
"""Rings along the drawn hole, as many as the markers of other viewers have, and segments of a ring, of 32, between two
lines along the hole; chosen."""
VIEW, TRAIL = 1.2, 2.0
"""Distance from which the hole is seen first, over its largest extent, by sight; length of the path that an orbit
shows [s], as in the report's view; chosen."""
LINE, SPOT = -1.0, -6.0
"""Radii of lines and marks; a negative radius is a size on the screen for rerun, in its points; chosen by sight."""


def recording(bag: Path, selection: Selection, folder: Path, *, replace: bool) -> None:
    """Write run.rrd of a part of a bag.

    Raises:
        ArgumentError: The package rerun-sdk is not installed.
        BagError: The bag cannot be analysed, or the file exists or cannot be written.
    """
    rr = import_extra("rerun")
    check_new(path := folder / "run.rrd", replace=replace)
    with shown_progress("analysing the bag"):
        run = read_recording(bag, None, selection)
        summary = summarise(run)
        stream, layout, told = rr.RecordingStream("drill_twin"), rr.blueprint, verdict(summary)
        memory, columns = stream.memory_recording(), list[Any]()
        if run.nodes and run.scene_known:
            columns.append(_well(rr, stream, run))
            told.append(f"The view of the string has {len(run.poses)} of {run.poses.seen} poses.")
        events = [(row["start_s"], "INFO", f"{row['state']}: {row['criterion']}") for row in summary["motion"]]
        if summary["onset_s"] is not None:
            events.append((summary["onset_s"], "WARN", f"onset of whirl: {onset_text(summary)}"))
        if events:
            times, levels, texts = zip(*sorted(events), strict=True)
            _over_time(rr, stream, "events", 1e9 * np.array(times), rr.TextLog.columns(text=texts, level=levels))
        stream.log("verdict", rr.TextDocument("\n\n".join(told), media_type="text/markdown"), static=True)
        views = [layout.Grid(*orbits)] if (orbits := list(_orbits(rr, stream, run))) else []
        views += [layout.TextLogView(origin="events"), layout.TextDocumentView(origin="verdict")]
        columns += [layout.Vertical(*views), layout.Vertical(*_trends(rr, stream, run))]
        stream.send_blueprint(layout.Blueprint(layout.Horizontal(*columns), collapse_panels=True))
        write_file(path, bytes(memory.drain_as_bytes()))
    print(path)
    remark(f"open it with: rerun {path}")


def _well(rr: Any, stream: Any, run: Recording) -> Any:
    """Write hole, string and marks to north, east and down, and make a view of them."""
    scene, curves, hole = run.scene, smooth(run.poses.position, run.poses.tangent), run.scene.hole
    up = arc_of(curves[0])
    geometry = string_geometry(scene, up * scene.length / up[-1])
    drawn = ExaggeratedGeometry(geometry, factor := default_exaggeration(scene.length, hole.radius))
    turn = top_frame(hole.top_inclination, hole.survey[0].azimuth if hole.survey else 0.0)
    stream.log("well", rr.ViewCoordinates.RIGHT_HAND_Z_DOWN, static=True)
    depths = np.unique([*np.linspace(0.0, scene.length, RINGS), *(bottom for _, bottom, _ in geometry.hole_steps)])
    radii = np.array([hole.radius_at(depth) for depth in depths.tolist()])
    rings = drawn.rings(depths, radii).reshape(depths.size, -1, 3) @ turn
    lines = [*rings, *rings[:, ::SEGMENTS].swapaxes(0, 1)]
    stream.log("well/hole", rr.LineStrips3D(lines, radii=LINE, colors=GREY), static=True)
    parts, points = geometry.strings, drawn.nodes(curves) @ turn
    strips = rr.LineStrips3D.columns(strips=[row[part] for row in points for part, _ in parts])
    _over_time(rr, stream, "well/string", run.poses.stamp, strips.partition([len(parts)] * len(points)))
    thick = [factor * radius for _, radius in parts]
    stream.log("well/string", rr.LineStrips3D.from_fields(radii=thick, colors=LIGHT), static=True)
    if run.places and not run.sub:  # the place of a sub is about its mean
        before = np.maximum(np.searchsorted(run.marks.stamp, run.poses.stamp, side="right") - 1, 0)
        columns = [run.marks.names.index(name) for name in geometry.mark_names]
        spots = drawn.marks(run.marks.position[before][:, columns]) @ turn
        rows = rr.Points3D.columns(positions=spots.reshape(-1, 3)).partition([len(columns)] * len(spots))
        _over_time(rr, stream, "well/marks", run.poses.stamp, rows)
        stream.log("well/marks", rr.Points3D.from_fields(radii=SPOT, labels=geometry.mark_names), static=True)
    middle, wide = rings.mean(axis=(0, 1)), float(np.ptp(rings, axis=(0, 1)).max())
    eye = middle + VIEW * wide * np.array((0.0, -1.0, -0.2))
    controls = rr.blueprint.EyeControls3D(position=eye, look_target=middle, eye_up=(0.0, 0.0, -1.0))
    name = f"string in the hole, lateral distances x {factor:g}"
    return rr.blueprint.Spatial3DView(origin="well", name=name, eye_controls=controls)


def _orbits(rr: Any, stream: Any, run: Recording) -> Iterator[Any]:
    """Write path and circle of contact of the centre line at each mark, and make a view of each."""
    layout, shown = rr.blueprint, run.units.show
    since, now = (layout.TimeRangeBoundary.cursor_relative(seconds=ago) for ago in (-TRAIL, 0.0))
    trail = [layout.VisibleTimeRange("time", start=since, end=now)]
    stream.log("orbits", rr.Transform3D(mat3x3=np.diag([1.0, -1.0, 1.0])), static=True)  # y points down in flat views
    centres, turn = run.centre_lines(), np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 65))
    for number, mark in enumerate(run.places):
        path, wall = (
            shown(points, "offset").view(float).reshape(-1, 2) for points in (centres[:, number], mark.clearance * turn)
        )
        entity = f"orbits/{mark.name}"
        rows = rr.LineStrips2D.columns(strips=np.stack((path[:-1], path[1:]), axis=1))
        _over_time(rr, stream, f"{entity}/path", run.marks.stamp[1:], rows)
        stream.log(f"{entity}/path", rr.LineStrips2D.from_fields(radii=LINE), static=True)
        stream.log(f"{entity}/wall", rr.LineStrips2D([wall], radii=LINE, colors=GREY), static=True)
        name = f"{mark.name} [{run.units.offset}]"
        yield layout.Spatial2DView(origin="orbits", contents=f"{entity}/**", name=name, time_ranges=trail)


def _trends(rr: Any, stream: Any, run: Recording) -> Iterator[Any]:
    """Write channels of the rig and the severity that was recorded, and make a view of each quantity."""
    found = [
        (
            f"{label} [{getattr(run.units, of)}]",
            run.rig.stamp,
            {name: run.units.show(x, of) for name, x in lines.items()},
        )
        for label, of, lines, _ in rig_panels(run)
    ]
    raws = [raw for _, _, raw in run.bag.messages((TWIN_SUMMARY,))] if run.runs == 1 else []
    states = JointStateReader().read_rows(raws) if raws else None
    if states is not None and "severity" in states.names:
        stamps, grades = np.array(states.stamps), states.position[:, states.names.index("severity")]
        inside = (run.rig.stamp[0] <= stamps) & (stamps <= run.rig.stamp[-1]) & (grades != UNKNOWN)
        found.append(("severity, 0 none to 4 severe", stamps[inside], {"grade": grades[inside]}))
    for name, stamps, lines in found:
        origin = f"trends/{name.partition(' [')[0].partition(',')[0].replace(' ', '_')}"
        for line, values in lines.items():
            entity, known = f"{origin}/{line.replace(' ', '_')}", np.isfinite(values)
            _over_time(rr, stream, entity, stamps[known], rr.Scalars.columns(scalars=values[known]))
            colour = ORANGE if line == "bit" else BLUE
            stream.log(entity, rr.SeriesLines(names=line, colors=colour), static=True)
        yield rr.blueprint.TimeSeriesView(origin=origin, name=name)


def _over_time(rr: Any, stream: Any, entity: str, stamps: Any, columns: Any) -> None:
    """Write columns with a row at each stamp [ns], shape (T,)."""
    stamps = rr.TimeColumn("time", duration=stamps.astype("timedelta64[ns]"))
    stream.send_columns(entity, [stamps], columns)
