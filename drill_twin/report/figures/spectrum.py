# SPDX-License-Identifier: Apache-2.0
"""Two-sided spectrum of the centre line: forward whirl to the right of zero, backward whirl to the left."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drill_twin.report.figures.style import GREY, INK, LEFT, RIGHT, VERMILION, blank, head, mark_style, note
from drill_twin.report.recording import Recording
from drill_twin.whirl import AnalysisError, two_sided_spectrum

_SHORTEST = 2.0
"""Least time after the onset for which the spectrum begins at the onset [s]."""


def spectrum(recording: Recording) -> Figure:
    """All marks in one panel, radius [mm] against signed frequency [Hz], with rotation and whirl."""
    figure = blank(3.9)
    panel = figure.add_axes((LEFT, 0.14, RIGHT - LEFT, 0.70))
    time, centre = recording.marks.time, recording.centre_lines()
    onset = recording.summary.onset
    begin = 0.0
    if onset is not None and recording.duration - onset.time_s > _SHORTEST:
        begin = onset.time_s
    head(figure, f"Spectrum of the centre line, {begin:.1f} to {recording.duration:.1f} s")
    chosen = time >= begin
    sign = -1.0 if (recording.summary.rotation_rev_s or 1.0) < 0.0 else 1.0
    highest = 0.0
    for mark, place in enumerate(recording.places):
        try:
            found = two_sided_spectrum(time[chosen], centre[chosen, mark])
        except AnalysisError as error:
            panel.text(0.5, 0.5, str(error), transform=panel.transAxes, ha="center", color=GREY)
            break
        radius = found.radius * 1e3
        highest = max(highest, float(radius.max()))
        panel.semilogy(sign * found.frequency, radius, label=place.name, **mark_style(mark))
    _lines(panel, recording)
    panel.set_ylim(max(highest, 1e-6) * 1e-4, max(highest, 1e-6) * 2.0)
    panel.set_xlabel("frequency [Hz], positive = the sense of rotation")
    panel.set_ylabel("radius of the orbit [mm]")
    if highest:
        figure.legend(loc="upper right", bbox_to_anchor=(0.985, 0.995), ncols=6)
    return figure


def _lines(panel: Axes, recording: Recording) -> None:
    summary = recording.summary
    rotation = abs(summary.rotation_rev_s or 0.0)
    width = max(2.5 * rotation, 1.6 * abs(summary.whirl_frequency_hz or 0.0), 1.0)
    rate = (len(recording.marks) - 1) / max(recording.duration, 1e-9)
    width = min(width, 0.5 * rate) if rate else width
    panel.set_xlim(-width, width)
    panel.axvspan(panel.get_xlim()[0], 0.0, color="#f3f3f3", zorder=0)
    inside = {"va": "top", "color": GREY}
    note(panel, "backward", (0.0, 1.0), where="axes fraction", shift=(5, -5), ha="left", **inside)
    note(panel, "forward", (1.0, 1.0), where="axes fraction", shift=(-5, -5), ha="right", **inside)
    whirl = summary.whirl_frequency_hz
    named = [(rotation, f"rotation {rotation:.2f} Hz", INK)] if rotation else []
    if whirl is not None:
        named.append((whirl, f"whirl {whirl:+.2f} Hz", VERMILION))
    named.sort()
    for number, (frequency, name, colour) in enumerate(named):
        panel.axvline(frequency, color=colour, linewidth=1.1, linestyle=(0, (4, 2)), zorder=1, gid=name)
        looks = {"ha": "left" if number else "right", "va": "bottom", "fontsize": 9.5, "color": colour}
        note(panel, name, (frequency, 1.0), where=("data", "axes fraction"), shift=(0, 3), **looks)
