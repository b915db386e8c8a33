# SPDX-License-Identifier: Apache-2.0
"""Displacement of the marks over time: x, y and distance from the axis, as in Figs 4 to 6 of the paper."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from drill_twin.report.figures.style import BLUE, GREY, INK, ORANGE, RIGHT, draw_onset, mark_label, over_time
from drill_twin.report.load_text import millimetres
from drill_twin.report.recording import Recording


def displacement(recording: Recording) -> Figure:
    """One panel a place with marks, all with one scale [mm], with the limits of the centre line."""
    time, centre = recording.marks.time, recording.centre_lines() * 1e3
    at: dict[float, list[int]] = {}
    for number, place in enumerate(recording.places):
        at.setdefault(place.distance_from_bit, []).append(number)
    numbers = [group[0] for group in at.values()]
    places = [recording.places[number] for number in numbers]
    largest = float(np.nanmax(np.abs(centre), initial=0.0))
    nearest = min(place.clearance for place in places) * 1e3
    limit = 1.12 * max(largest, nearest if largest > 0.4 * nearest else 1e-3)
    figure, panels = over_time(
        recording.duration, [1.25] * len(places), title="Displacement of the centre line at the marks", headed=True
    )
    for number, panel, place in zip(numbers, panels, places, strict=True):
        z = centre[:, number]
        radius = np.abs(z)
        panel.fill_between(time, -radius, radius, color=INK, alpha=0.10, linewidth=0, label="distance from axis")
        panel.plot(time, z.real, color=BLUE, linewidth=0.9, label="x")
        panel.plot(time, z.imag, color=ORANGE, linewidth=0.9, label="y")
        for side in (-1.0, 1.0):
            panel.axhline(side * place.clearance * 1e3, color=GREY, linewidth=1.0, linestyle=":")
        panel.set_ylim(-max(limit, 1e-6), max(limit, 1e-6))
        panel.set_ylabel("[mm]")
        name = mark_label(*(recording.places[mark] for mark in at[place.distance_from_bit]))
        panel.set_title(f"{name}: at most {millimetres(1e-3 * np.nanmax(radius))}", fontsize=10.5, pad=3)
    draw_onset(recording.summary.onset, recording.duration, panels)
    handles, labels = panels[0].get_legend_handles_labels()
    if limit > nearest:
        handles.append(panels[0].get_lines()[2])
        labels.append("touches the wall")
    figure.legend(handles, labels, loc="upper right", bbox_to_anchor=(RIGHT, 1.0), ncols=4, borderaxespad=0.3)
    return figure
