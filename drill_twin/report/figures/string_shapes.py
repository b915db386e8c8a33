# SPDX-License-Identifier: Apache-2.0
"""Shapes of the string in 3-D at several instants, and paths of the marks."""

from __future__ import annotations

import math
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from drill_twin.report.figures.orbits import MAP
from drill_twin.report.figures.style import GREY, INK, LIGHT, blank, head, mark_style
from drill_twin.report.recording import Recording

_SHAPES = 9
_REVOLUTIONS = 2.0
"""Length of the paths of the marks at the end of the run, in revolutions of rotation or whirl, the slower one."""


def string_shapes(recording: Recording) -> Figure:
    """Left: shapes over the run; right: the last revolutions, with the paths of the marks. Lateral axes stretched."""
    figure = blank(6.6)
    head(figure, "The string in the hole (lateral axes stretched)")
    if not len(recording.poses):
        figure.text(0.5, 0.5, "the bag holds no poses of the string", ha="center", color=GREY)
        return figure
    time, shapes = recording.poses.time, recording.shapes() * (1e3, 1e3, 1.0)
    last = float(time[-1])
    since = last - _window(recording)
    norm = Normalize(0.0, last)
    run, end = (_box(figure, recording, side) for side in (0, 1))
    for instant in np.linspace(float(time[0]), last, _SHAPES):
        shape = shapes[int(np.argmin(np.abs(time - instant)))]
        run.plot(*shape.T, color=mpl.colormaps[MAP](norm(instant)), linewidth=1.6)
    for instant in np.linspace(since, last, _SHAPES):
        shape = shapes[int(np.argmin(np.abs(time - instant)))]
        end.plot(*shape.T, color=INK, linewidth=2.0 if instant == last else 0.8, alpha=1.0 if instant == last else 0.3)
    _paths(end, recording, since)
    figure.legend(*end.get_legend_handles_labels(), loc="upper right", bbox_to_anchor=(0.985, 0.995), ncols=6)
    for side, text in enumerate(
        (
            f"{_SHAPES} shapes over the run{', the curved hole drawn straight' if recording.scene.hole.survey else ''}",
            f"the last {last - since:.1f} s, and the marks' paths",
        )
    ):
        figure.text(0.275 + 0.465 * side, 0.905, text, ha="center", fontsize=11.5)
    bar = figure.add_axes((0.036, 0.3, 0.011, 0.4))
    figure.colorbar(ScalarMappable(norm, MAP), cax=bar)
    bar.set_title("time [s]", loc="center", fontsize=9.5)
    return figure


def _window(recording: Recording) -> float:
    """Time of the last revolutions [s]."""
    summary = recording.summary
    rates = [abs(rate) for rate in (summary.whirl_frequency_hz, summary.rotation_rev_s) if rate]
    return min(_REVOLUTIONS / min(rates, default=1.0), 0.5 * recording.duration)


def _paths(panel: Any, recording: Recording, since: float) -> None:
    time, centre = recording.marks.time, recording.centre_lines() * 1e3
    height, chosen = recording.marks.position[..., 2], time >= since
    for mark, place in enumerate(recording.places):
        z = centre[chosen, mark]
        style = {**mark_style(mark), "linewidth": 1.6}
        panel.plot(z.real, z.imag, height[chosen, mark], label=place.name, **style)


def _box(figure: Figure, recording: Recording, side: int) -> Any:
    """3-D axes with rings at the wall; z = 0 is the top clamp."""
    panel: Any = figure.add_axes((0.045 + 0.465 * side, 0.0, 0.48, 0.93), projection="3d")
    hole, length = recording.scene.hole, recording.scene.length
    depths = [*np.linspace(0.0, length, 6), *(end for step in hole.intervals for end in (step.top, step.bottom))]
    radii = {depth: 1e3 * hole.radius_at(float(depth)) for depth in depths if depth <= length}
    radius = max(radii.values())
    angle = np.linspace(0.0, math.tau, 73)
    for depth, wall in radii.items():
        ring = np.full_like(angle, -depth)
        panel.plot(wall * np.cos(angle), wall * np.sin(angle), ring, color=GREY, linewidth=0.6, alpha=0.7)
    panel.set_box_aspect((1.0, 1.0, 1.9), zoom=1.0)
    panel.view_init(elev=18, azim=-58)
    panel.set(xlim=(-radius, radius), ylim=(-radius, radius), zlim=(-length, 0.0))
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(MaxNLocator(3))
    panel.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [m]")
    for axis in (panel.xaxis, panel.yaxis, panel.zaxis):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.line.set_color(LIGHT)
    panel.tick_params(labelsize=9, colors=INK)
    return panel
