# SPDX-License-Identifier: Apache-2.0
"""Runs beside each other, such as a recorded one and the same commands computed again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drill_twin.report.figures.style import BLUE, GREEN, PURPLE, RIGHT, VERMILION, over_time, styled
from drill_twin.report.load_text import millimetres
from drill_twin.report.recording import Recording

_RECORDED: dict[str, Any] = {"color": BLUE, "linewidth": 2.2, "alpha": 0.45}
_COMPUTED: dict[str, Any] = {"color": VERMILION, "linewidth": 0.9}
_BESIDE = tuple({"color": colour, "linewidth": 1.2, "alpha": 0.85} for colour in (BLUE, VERMILION, GREEN, PURPLE))
_NEWTONS = (("hookload", "hookload_n", "N"), ("weight on bit", "weight_on_bit_n", "N"), ("drag", "drag_n", "N"))
_TORQUES = (
    ("top-drive torque", "top_drive_torque_nm", "N m"),
    ("bit torque", "bit_torque_nm", "N m"),
)


def comparison(recorded: Mapping[str, Any], computed: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Rows of quantity, recorded value and computed value, as text with units, from two summaries."""
    first, second = dict(_values(recorded)), dict(_values(computed))
    return [(name, first.get(name, "none"), second.get(name, "none")) for name in first | second]


def _values(summary: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    onset = summary["onset_s"]
    yield "onset of whirl", "none" if onset is None else f"{onset:.2f} s, {summary['onset_mark']}"
    yield "whirl frequency", _text(summary["whirl_frequency_hz"], "{:+.3f} Hz")
    yield "precession / rotation", _text(summary["precession_ratio"], "{:+.3f}")
    yield "rotation", _text(summary["rotation_rev_s"], "{:.3f} rev/s")
    for mark, radius in summary["max_radius_m"].items():
        yield f"largest radius, {mark}", "not seen" if radius is None else millimetres(radius)
    for name, key, unit in (*_NEWTONS, *_TORQUES):
        found = summary["loads"].get(key)
        yield name, f"{found['mean']:.4g} {unit}, {found['min']:.4g} to {found['max']:.4g}" if found else "none"
    yield "motion at the end", summary["motion"][-1]["state"] if summary["motion"] else "unknown"
    yield "bit at the end", summary["bit"]
    yield "simulated time", f"{summary['duration_s']:.2f} s"


def _text(value: float | None, form: str) -> str:
    return "none" if value is None else form.format(value)


def draw_comparison(recorded: Recording, computed: Recording) -> Figure:
    """Both runs over time: distance of the marks from the axis, hookload, torque and speed of the bit."""
    return draw_runs(
        [("recorded", recorded), ("computed again", computed)], "Recorded, and computed again", (_RECORDED, _COMPUTED)
    )


def draw_runs(runs: Sequence[tuple[str, Recording]], title: str, styles: Sequence[dict[str, Any]] = _BESIDE) -> Figure:
    """Runs over time: distance of the marks that all have from the axis, hookload, torque and speed of the bit.

    Args:
        runs: Name and recording.
        title: Of the figure.
        styles: Of the lines of each run.
    """
    with_marks = all(len(run.marks) for _, run in runs)
    tables = [[place.name for place in run.scene.mark_table] if with_marks else [] for _, run in runs]
    marks = [name for name in tables[0] if all(name in table for table in tables)]
    with styled():
        longest = max(run.duration for _, run in runs)
        figure, panels = over_time(longest, [1.1] * (len(marks) + 3), title=title, headed=True)
        styled_runs = [(run, styles[k % len(styles)]) for k, (_, run) in enumerate(runs)]
        for panel, name in zip(panels, marks, strict=False):
            for (run, style), table in zip(styled_runs, tables, strict=True):
                radius = 1e3 * np.abs(run.centre_lines()[:, table.index(name)])
                panel.plot(run.marks.time, radius, **style)
            panel.set_title(f"{name}: distance of the centre line from the axis", fontsize=10.5, pad=3)
            panel.set_ylabel("[mm]")
        for panel, name, heading, unit, factor in zip(
            panels[len(marks) :],
            ("hookload", "top_drive_torque", "bit_speed"),
            ("hookload", "torque of the top drive", "speed of the bit"),
            ("[N]", "[N m]", "[rev/s]"),
            (1.0, 1.0, 0.5 / np.pi),
            strict=True,
        ):
            for run, style in styled_runs:
                panel.plot(run.rig.time, factor * getattr(run.rig, name), **style)
            panel.set_title(heading, fontsize=10.5, pad=3)
            panel.set_ylabel(unit)
        for run, style in styled_runs:
            if run.summary.onset is not None:
                for panel in panels:
                    panel.axvline(run.summary.onset.time_s, **{**style, "linewidth": 1.2}, linestyle=(0, (4, 2)))
        labels = [name for name, _ in runs]
        labels[-1] += " (dashed: onset of whirl)"
        handles = panels[-1].get_lines()[: len(runs)]
        figure.legend(handles, labels, loc="upper right", bbox_to_anchor=(RIGHT, 1.0), ncols=2, borderaxespad=0.3)
    return figure
