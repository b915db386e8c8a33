# SPDX-License-Identifier: Apache-2.0
"""Orbits of the centre line in the cross-section of the hole, seen from above, one panel a mark."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from drill_twin.base.arrays import Array, ComplexArray
from drill_twin.report.figures.style import GREY, INK, LIGHT, WIDTH, blank, head, mark_label, note
from drill_twin.report.recording import Recording

COLUMNS = 4
MAP = "cividis_r"
_SEGMENTS = 6000
"""Most line segments of an orbit."""


def orbits(recording: Recording) -> Figure:
    """Wall (thick), limit of the centre line (dotted), and orbit, coloured by time."""
    places = recording.scene.mark_table
    columns = min(COLUMNS, len(places))
    rows = math.ceil(len(places) / columns)
    side = min(WIDTH * 0.95 / columns, 4.2)
    top, bottom = 0.45, 1.05
    height = rows * (side + 0.1) + top + bottom
    figure = blank(height)
    head(figure, "Orbits of the centre line across the hole, seen from above")
    norm = Normalize(0.0, recording.duration)
    time, centre = recording.marks.time, recording.centre_lines() * 1e3
    left = 0.5 * (1.0 - columns * side / WIDTH) + 0.015
    for number in range(len(places)):
        row, column = divmod(number, columns)
        rectangle = (
            left + (column * side + 0.14 * side) / WIDTH,
            1.0 - (top + (row + 1) * side + row * 0.1 - 0.03 * side) / height,
            0.84 * side / WIDTH,
            0.84 * side / height,
        )
        panel = figure.add_axes(rectangle)
        _orbit(panel, recording, number, time, centre[:, number], norm)
        panel.tick_params(labelleft=column == 0, labelbottom=number + columns >= len(places))
        panel.set_ylabel("y [mm]" if column == 0 else "", labelpad=1)
        panel.set_xlabel("x [mm]" if number + columns >= len(places) else "", labelpad=1)
    bar = figure.add_axes((0.3, 0.52 / height, 0.4, 0.11 / height))
    figure.colorbar(ScalarMappable(norm, MAP), cax=bar, orientation="horizontal", label="time [s]")
    onset = recording.summary.onset
    if onset is not None:
        bar.axvline(onset.time_s, color=INK, linewidth=1.4, linestyle=(0, (2, 1)))
        looks = {"ha": "center", "va": "bottom", "fontsize": 9}
        note(bar, "onset", (onset.time_s, 1.0), where=("data", "axes fraction"), shift=(0, 2), **looks)
    return figure


def _orbit(
    panel: Axes,
    recording: Recording,
    number: int,
    time: Array,
    centre: ComplexArray,
    norm: Normalize,
) -> None:
    place, wall = recording.scene.mark_table[number], recording.scene.hole.radius * 1e3
    panel.add_patch(Circle((0.0, 0.0), wall, facecolor="white", edgecolor=INK, linewidth=1.8, zorder=1))
    reach = place.clearance * 1e3
    panel.add_patch(Circle((0.0, 0.0), reach, fill=False, edgecolor=GREY, linewidth=0.9, linestyle=":", zorder=3))
    every = max(1, time.size // _SEGMENTS)
    points = np.column_stack((centre.real, centre.imag))[::every]
    lines = LineCollection(list(np.stack((points[:-1], points[1:]), axis=1)), cmap=MAP, norm=norm, linewidth=0.9)
    lines.set_array(time[::every][:-1])
    lines.set_zorder(2)
    panel.add_collection(lines)
    panel.plot([points[-1, 0]], [points[-1, 1]], "o", color=INK, markersize=4, zorder=4)
    panel.set_facecolor(LIGHT)
    panel.grid(visible=False)
    edge = 1.07 * wall
    panel.set_xlim(-edge, edge)
    panel.set_ylim(-edge, edge)
    panel.set_aspect("equal")
    panel.set_title(mark_label(recording, number).replace(" from the bit", " from bit"), fontsize=10.5, loc="center")
