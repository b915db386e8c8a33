# SPDX-License-Identifier: Apache-2.0
"""Figures over time: the rig as far as it is recorded, displacement of the marks, motion states.

Set-points are drawn as commanded; displacement as x, y and distance from the axis, as in Figs 4 to 6 of the paper;
motion states with the precession that decides them; runs beside each other, as a recorded one and the same commands
computed again.
"""

import math
from collections.abc import Iterator, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from drill_twin.core.arrays import Array
from drill_twin.core.units.system import UnitSystem
from drill_twin.report.figures.orbits import by_depth
from drill_twin.report.figures.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    RIGHT,
    STATE_COLOURS,
    VERMILION,
    draw_onset,
    mark_label,
    mark_style,
    note,
    over_time,
    styled,
    unbridged,
)
from drill_twin.report.recording import Recording
from drill_twin.report.surface import CHANNELS, without_spikes
from drill_twin.whirl import MotionPeriod, MotionState, criteria

_Panel = tuple[str, str, dict[str, Array], Array | None]
"""Label and quantity of a panel, its lines by name, and what was commanded."""


def set_points(recording: Recording) -> Figure:
    """One panel a quantity of the rig that the recording holds."""
    found = list(rig_panels(recording))
    title = ", ".join(label for label, *_ in found).capitalize()
    figure, panels = over_time(recording.duration, [1.35] * len(found), title=title)
    units = recording.units
    if not recording.places and len(recording.rig):
        panels[0].set_xlim(left=float(recording.rig.time[0]))
    for panel, (label, quantity, lines, commanded) in zip(panels, found, strict=True):
        if commanded is not None:
            given = np.isfinite(commanded)  # a command may have a part of the set-points
            wanted = units.show(commanded[given], quantity)
            panel.plot(recording.commands.time[given], wanted, color=GREY, linewidth=4.5, alpha=0.4, label="commanded")
        for name, values in lines.items():
            colour, line = (ORANGE, "--") if name == "bit" else (BLUE, "-")
            time, drawn = unbridged(recording.rig.time, units.show(values, quantity))
            panel.plot(time, drawn, color=colour, linestyle=line, label=name)
        panel.set_ylabel(f"{label} [{getattr(units, quantity)}]")
        panel.margins(y=0.12)
        if len(panel.get_lines()) > 1:
            panel.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.2)
    draw_onset(recording.summary.onset, recording.duration, panels)
    return figure


def rig_panels(recording: Recording) -> Iterator[_Panel]:
    """Panels with at least one line that has values; spikes, which would set the axes, are left out."""
    recorded, kept, commands = recording.rig, without_spikes(recording), recording.commands
    rig = SimpleNamespace(**{name: kept.get(name, getattr(recorded, name)) for name in (*CHANNELS, "bit_torque")})
    for label, quantity, lines, commanded in (
        ("weight on bit", "force", {"applied": rig.bit_force}, commands.weight_on_bit if len(commands) else None),
        ("rotation", "rotation", {"top drive": rig.top_drive_speed, "bit": rig.bit_speed},
         commands.rotation if len(commands) else None),
        ("torque", "torque", {"top drive": rig.top_drive_torque, "bit": -rig.bit_torque}, None),
        ("hookload", "force", {"hookload": rig.hookload}, None),
    ):  # fmt: skip
        if known := {name: values for name, values in lines.items() if np.isfinite(values).any()}:
            yield label, quantity, known, commanded


def displacement(recording: Recording) -> Figure:
    """One panel a place with marks, all with one scale, with the limits of the centre line."""
    units, lines = recording.units, recording.centre_lines()
    time, centre = recording.marks.time, units.show(lines, "offset")
    groups = [[recording.places[number] for number in numbers] for numbers in by_depth(recording)]
    places = [group[0] for group in groups]
    largest = float(np.nanmax(np.abs(centre), initial=0.0))
    nearest = units.show(min(place.clearance for place in places), "offset")
    limit = 1.12 * max(largest, nearest if largest > 0.4 * nearest else 1e-3)
    figure, panels = over_time(
        recording.duration, [1.25] * len(places), title="Displacement of the centre line at the marks", headed=True
    )
    for panel, group in zip(panels, groups, strict=True):
        place, number = group[0], recording.places.index(group[0])
        radius = np.abs(z := centre[:, number])
        panel.fill_between(time, -radius, radius, color=INK, alpha=0.10, linewidth=0, label="distance from axis")
        panel.plot(time, z.real, color=BLUE, linewidth=0.9, label="x")
        panel.plot(time, z.imag, color=ORANGE, linewidth=0.9, label="y")
        for side in (-1.0, 1.0):
            panel.axhline(side * units.show(place.clearance, "offset"), color=GREY, linewidth=1.0, linestyle=":")
        panel.set(ylim=(-max(limit, 1e-6), max(limit, 1e-6)), ylabel=f"[{units.offset}]")
        widest = units.text(float(np.nanmax(np.abs(lines[:, number]))), "offset")
        panel.set_title(f"{mark_label(units, *group)}: at most {widest}", fontsize=10.5, pad=3)
    draw_onset(recording.summary.onset, recording.duration, panels)
    handles, labels = panels[0].get_legend_handles_labels()
    if limit > nearest:
        handles.append(panels[0].get_lines()[2])
        labels.append("touches the wall")
    figure.legend(handles, labels, loc="upper right", bbox_to_anchor=(RIGHT, 1.0), ncols=4, borderaxespad=0.3)
    return figure


_ROW = 0.34
_ROOM = 11
"""Number of letters of a name that fit beside the bands."""
_LETTER = 0.0078
"""Width of a letter, as a share of the time axis."""


def motion(recording: Recording) -> Figure:
    """Bands of motion states of the string and of each mark; below, signed whirl ratio."""
    summary = recording.summary
    rows = {"string": summary.motion, **summary.mark_motion}
    figure, (bands, ratio) = over_time(recording.duration, [_ROW * len(rows), 1.9], title="Motion and whirl ratio")
    for row, periods in enumerate(rows.values()):
        _band(bands, row, periods, recording.duration)
    bands.set_ylim(len(rows) - 0.5, -0.5)
    longest = max(len(name) for name in rows)
    bands.set_yticks(range(len(rows)), list(rows), fontsize=min(10.5, 10.5 * _ROOM / longest))
    bands.grid(visible=False)
    bands.tick_params(length=0)
    bands.spines[["left", "bottom"]].set_visible(False)
    _ratio(ratio, recording)
    draw_onset(summary.onset, recording.duration, [bands, ratio])
    _legend(figure, [period.state for periods in rows.values() for period in periods])
    return figure


def _band(panel: Axes, row: int, periods: tuple[MotionPeriod, ...], end: float) -> None:
    starts = [0.0, *(period.start_s for period in periods[1:])]
    for start, stop, period in zip(starts, [*starts[1:], end], periods, strict=False):
        name = period.state.value
        panel.barh(row, stop - start, left=start, height=0.78, color=STATE_COLOURS[period.state], linewidth=0,
                   gid=f"{name}, {start:.2f} to {stop:.2f} s")  # fmt: skip
        if (stop - start) / max(end, 1e-9) > _LETTER * len(name):
            dark = period.state in {MotionState.ROLLING, MotionState.BACKWARD_WHIRL, MotionState.IMPACTS}
            panel.text(
                0.5 * (start + stop), row, name, ha="center", va="center", fontsize=9, color="white" if dark else INK
            )


def _ratio(panel: Axes, recording: Recording) -> None:
    time, ratios = recording.whirl.time, recording.whirl.ratio
    clearance = np.array([place.clearance for place in recording.places])
    large = recording.whirl.orbit_radius > criteria.ONSET_RADIUS * clearance
    for mark, name in enumerate(recording.findings.marks):
        panel.plot(time, ratios[:, mark], linewidth=0.8, alpha=0.25, **mark_style(mark))
        wide = np.where(large[:, mark], ratios[:, mark], np.nan)
        panel.plot(time, wide, linewidth=1.5, label=name, **mark_style(mark))
    seen = ratios[large & np.isfinite(ratios)]
    low, high = np.percentile(seen, [1.0, 99.0]) if seen.size else (0.0, 1.0)
    panel.set(
        ylim=(max(min(low - 0.1, -0.3), -3.0), min(max(high + 0.1, 1.25), 3.0)),
        ylabel="whirl ratio\n- backward, + forward",
    )
    panel.axhline(0.0, color=GREY, linewidth=1.0)
    panel.axhline(1.0, color=GREY, linewidth=1.0, linestyle="--")
    looks = {"ha": "right", "va": "bottom", "fontsize": 8.5, "color": GREY}
    note(panel, "as fast as the string turns", (1.0, 1.0), where=("axes fraction", "data"), shift=(-3, 2), **looks)
    share = f"{100 * criteria.ONSET_RADIUS:g} %"
    panel.set_title(f"Whirl ratio (faint: within {share} of the clearance)", fontsize=10.5, pad=4)
    panel.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=min(6, ratios.shape[1]), borderaxespad=0.2)


def _legend(figure: Figure, states: list[MotionState]) -> None:
    handles = [Patch(color=STATE_COLOURS[state], label=state.value) for state in MotionState if state in states]
    columns = math.ceil(len(handles) / (1 if len(handles) <= 4 else 2))
    figure.legend(handles=handles, loc="upper right", bbox_to_anchor=(RIGHT, 1.0), ncols=columns, borderaxespad=0.3,
                  handlelength=1.0, columnspacing=1.2)  # fmt: skip


_COMPARED = (
    ("hookload", "hookload", "force"), ("top_drive_torque", "torque of the top drive", "torque"),
    ("bit_speed", "speed of the bit", "rotation"),
)  # fmt: skip
_BESIDE: tuple[dict[str, Any], ...] = (
    {"color": BLUE, "linewidth": 2.2, "alpha": 0.45},
    *({"color": colour, "linewidth": 0.9} for colour in (VERMILION, GREEN, PURPLE)),
)
"""Styles of the lines of runs: the first is seen under others that are the same."""


def draw_runs(runs: Sequence[tuple[str, Recording]], title: str, units: UnitSystem | None = None) -> Figure:
    """Runs over time: distance of the marks that all have from the axis, hookload, torque and speed of the bit.

    Args:
        runs: Name and recording.
        title: Of the figure.
        units: Units of the axes; by default the first run's.
    """
    with_marks = all(len(run.marks) for _, run in runs)
    tables = [[place.name for place in run.scene.mark_table] if with_marks else [] for _, run in runs]
    marks = [name for name in tables[0] if all(name in table for table in tables)]
    with styled():
        units = units or runs[0][1].units
        longest = max(run.duration for _, run in runs)
        figure, panels = over_time(longest, [1.1] * (len(marks) + len(_COMPARED)), title=title, headed=True)
        styled_runs = [(run, _BESIDE[k % len(_BESIDE)]) for k, (_, run) in enumerate(runs)]
        for panel, name in zip(panels, marks, strict=False):
            for (run, style), table in zip(styled_runs, tables, strict=True):
                radius = units.show(np.abs(run.centre_lines()[:, table.index(name)]), "offset")
                panel.plot(run.marks.time, radius, **style)
            panel.set_title(f"{name}: distance of the centre line from the axis", fontsize=10.5, pad=3)
            panel.set_ylabel(f"[{units.offset}]")
        for panel, (name, heading, quantity) in zip(panels[len(marks) :], _COMPARED, strict=True):
            for run, style in styled_runs:
                panel.plot(*unbridged(run.rig.time, units.show(getattr(run.rig, name), quantity)), **style)
            panel.set_title(heading, fontsize=10.5, pad=3)
            panel.set_ylabel(f"[{getattr(units, quantity)}]")
        for run, style in styled_runs:
            if run.summary.onset is not None:
                for panel in panels:
                    panel.axvline(run.summary.onset.time_s, **{**style, "linewidth": 1.2}, linestyle=(0, (4, 2)))
        labels = [name for name, _ in runs]
        labels[-1] += " (dashed: onset of whirl)" if any(run.summary.onset for run, _ in styled_runs) else ""
        handles = panels[-1].get_lines()[: len(runs)]
        figure.legend(handles, labels, loc="upper right", bbox_to_anchor=(RIGHT, 1.0), ncols=2, borderaxespad=0.3)
    return figure
