# SPDX-License-Identifier: Apache-2.0
"""Two-sided spectrum of the centre line: forward whirl to the right of zero, backward whirl to the left; or over time.

Over time the spectrum of the mark with most whirl is drawn, with multiples of the rotation; below, the orbits' radii.
"""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from drill_twin.report.figures.style import (
    GREY,
    INK,
    LEFT,
    RIGHT,
    VERMILION,
    blank,
    draw_onset,
    mark_label,
    mark_style,
    note,
    over_time,
)
from drill_twin.report.recording import Recording
from drill_twin.whirl import AnalysisError, two_sided_spectrum
from drill_twin.whirl import spectrum_over_time as sliding

_SHORTEST = 2.0
"""Least time after the onset for which the spectrum begins at the onset [s]."""


def spectrum(recording: Recording) -> Figure:
    """All marks in one panel, radius against signed frequency [Hz], with rotation and whirl."""
    time, centre, onset = recording.marks.time, recording.centre_lines(), recording.summary.onset
    late = onset is not None and recording.duration - onset.time_s > _SHORTEST
    begin = onset.time_s if onset is not None and late else 0.0
    figure = blank(3.9, f"Spectrum of the centre line, {begin:.1f} to {recording.duration:.1f} s")
    panel = figure.add_axes((LEFT, 0.14, RIGHT - LEFT, 0.70))
    chosen = time >= begin
    sign = -1.0 if (recording.summary.rotation_rev_s or 1.0) < 0.0 else 1.0
    highest = 0.0
    for mark, place in enumerate(recording.places):
        try:
            found = two_sided_spectrum(time[chosen], centre[chosen, mark])
        except AnalysisError as error:
            panel.text(0.5, 0.5, str(error), transform=panel.transAxes, ha="center", color=GREY)
            break
        radius = recording.units.show(found.radius, "offset")
        highest = max(highest, float(radius.max()))
        panel.plot(sign * found.frequency, radius, label=place.name, **mark_style(mark))
    _lines(panel, recording)
    panel.set(
        xlabel="frequency [Hz], positive = the sense of rotation",
        ylabel=f"radius of the orbit [{recording.units.offset}]",
    )
    if highest:
        panel.set(yscale="log", ylim=(1e-4 * highest, 2.0 * highest))
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


_REVOLUTIONS = 6.0
"""Length of the window [rev]."""
_MULTIPLES = (-1, 1, 2, 3)
_DEPTH = 1e-2
"""Smallest radius shown, over the largest."""
_STRING_MARK = 0.02
"""Share of the largest radius above which the precession is drawn."""


def spectrum_over_time(recording: Recording) -> Figure:
    """Two panels: radius of each line over time and signed frequency; radius of each mark's orbit over time."""
    mark = _leading_mark(recording)
    name = mark_label(recording.units, recording.places[mark])
    figure, (lines, radii) = over_time(recording.duration, [2.9, 1.3], title=f"Spectrum over time, {name}", headed=True)
    _spectra(lines, recording, mark)
    _rotation(lines, recording)
    time, radius = recording.whirl.time, recording.units.show(recording.whirl.orbit_radius, "offset")
    for number, place in enumerate(recording.places):
        radii.plot(time, radius[:, number], linewidth=1.0, label=place.name, **mark_style(number))
    radii.set(ylim=(0.0, None), ylabel=f"orbit radius [{recording.units.offset}]")
    radii.set_title("Distance of the centre line from the axis", fontsize=10.5, pad=4)
    radii.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=min(6, len(recording.places)), borderaxespad=0.2)
    draw_onset(recording.summary.onset, recording.duration, [lines, radii])
    return figure


def _leading_mark(recording: Recording) -> int:
    """Mark whose frequency the summary gives, else the one with the largest radius."""
    names = [place.name for place in recording.places]
    if recording.summary.frequency_mark in names:
        return names.index(recording.summary.frequency_mark)
    return int(np.argmax([recording.summary.max_radius_m.get(name) or 0.0 for name in names]))


def _spectra(panel: Axes, recording: Recording, mark: int) -> None:
    rotation = abs(recording.summary.rotation_rev_s or 0.0)
    sign = -1.0 if (recording.summary.rotation_rev_s or 1.0) < 0.0 else 1.0
    window = min(_REVOLUTIONS / rotation if rotation else math.inf, 0.25 * recording.duration)
    reach = 3.3 * rotation if rotation else 5.0
    panel.set(ylim=(-1.6 * rotation if rotation else -5.0, reach), ylabel="frequency [Hz]\n- backward, + forward")
    try:
        time, frequency, radius = sliding(recording.marks.time, recording.centre_lines()[:, mark], window)
    except AnalysisError as error:
        panel.text(0.5, 0.5, str(error), transform=panel.transAxes, ha="center", color=GREY, wrap=True)
        return
    inside = np.abs(frequency) <= 1.05 * reach
    order = np.argsort(sign * frequency[inside])
    shown = recording.units.show(radius[inside], "offset")[order]
    largest = max(float(shown.max()), 1e-6)
    panel.pcolormesh(
        time,
        (sign * frequency[inside])[order],
        np.maximum(shown, _DEPTH * largest),
        norm=LogNorm(_DEPTH * largest, largest),
        cmap="Greys",
        shading="nearest",
        rasterized=True,
    )
    panel.set_title(
        f"Darker is wider, up to {largest:.3g} {recording.units.offset} (black); window {window:.2g} s; orange: "
        "whirl frequency found",
        fontsize=10.5,
        pad=4,
    )
    panel.grid(visible=False)
    moved, precession = recording.whirl.orbit_radius[:, mark], recording.whirl.precession[:, mark]
    wide = np.where(moved > _STRING_MARK * np.nanmax(moved), precession, np.nan)
    panel.plot(recording.whirl.time, wide, ".", markersize=1.2, color=VERMILION)


def _rotation(panel: Axes, recording: Recording) -> None:
    if not len(recording.rig):
        return
    time, speed = recording.rig.time, np.abs(recording.rig.top_drive_speed) / math.tau
    for multiple in _MULTIPLES:
        style = "--" if multiple == 1 else ":"
        panel.plot(time, multiple * speed, color=INK, linewidth=1.1 if multiple == 1 else 0.9, linestyle=style)
        text = "rotation" if multiple == 1 else f"{multiple} x"
        looks = {"ha": "right", "va": "bottom", "fontsize": 8.5, "color": INK}
        note(panel, text, (1.0, float(multiple * speed[-1])), where=("axes fraction", "data"), shift=(-3, 1), **looks)
    panel.axhline(0.0, color=GREY, linewidth=0.8)
