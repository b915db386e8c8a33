# SPDX-License-Identifier: Apache-2.0
"""Runs beside each other, such as a recorded one and the same commands computed again."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drill_twin.core.units.system import UnitSystem
from drill_twin.report.figures.style import BLUE, GREEN, PURPLE, RIGHT, VERMILION, over_time, styled, unbridged
from drill_twin.report.recording import Recording

_RECORDED: dict[str, Any] = {"color": BLUE, "linewidth": 2.2, "alpha": 0.45}
_COMPUTED: dict[str, Any] = {"color": VERMILION, "linewidth": 0.9}
_CHANNELS = (
    ("hookload", "hookload", "force"), ("top_drive_torque", "torque of the top drive", "torque"),
    ("bit_speed", "speed of the bit", "rotation"),
)  # fmt: skip
_BESIDE = tuple({"color": colour, "linewidth": 1.2, "alpha": 0.85} for colour in (BLUE, VERMILION, GREEN, PURPLE))


def draw_comparison(recorded: Recording, computed: Recording) -> Figure:
    """Both runs over time: distance of the marks from the axis, hookload, torque and speed of the bit."""
    runs = [("recorded", recorded), ("computed again", computed)]
    return draw_runs(runs, "Recorded, and computed again", (_RECORDED, _COMPUTED), computed.units)


def draw_runs(
    runs: Sequence[tuple[str, Recording]],
    title: str,
    styles: Sequence[dict[str, Any]] = _BESIDE,
    units: UnitSystem | None = None,
) -> Figure:
    """Runs over time: distance of the marks that all have from the axis, hookload, torque and speed of the bit.

    Args:
        runs: Name and recording.
        title: Of the figure.
        styles: Styles of the lines of each run.
        units: Units of the axes; by default the first run's.
    """
    with_marks = all(len(run.marks) for _, run in runs)
    tables = [[place.name for place in run.scene.mark_table] if with_marks else [] for _, run in runs]
    marks = [name for name in tables[0] if all(name in table for table in tables)]
    with styled():
        units = units or runs[0][1].units
        longest = max(run.duration for _, run in runs)
        figure, panels = over_time(longest, [1.1] * (len(marks) + len(_CHANNELS)), title=title, headed=True)
        styled_runs = [(run, styles[k % len(styles)]) for k, (_, run) in enumerate(runs)]
        for panel, name in zip(panels, marks, strict=False):
            for (run, style), table in zip(styled_runs, tables, strict=True):
                radius = units.show(np.abs(run.centre_lines()[:, table.index(name)]), "offset")
                panel.plot(run.marks.time, radius, **style)
            panel.set_title(f"{name}: distance of the centre line from the axis", fontsize=10.5, pad=3)
            panel.set_ylabel(f"[{units.offset}]")
        for panel, (name, heading, quantity) in zip(panels[len(marks) :], _CHANNELS, strict=True):
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
