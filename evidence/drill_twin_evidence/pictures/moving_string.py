# SPDX-License-Identifier: Apache-2.0
"""Moving picture of the model rod: it buckles, whirls, and the analyzer announces the onset."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image
from scipy.interpolate import CubicHermiteSpline

import drill_twin as dt
from drill_twin.core.arrays import Array
from drill_twin.report.figures.style import BLUE, GREY, INK, LIGHT, VERMILION

SCENE, MARK = "pa6_bench", "mark_2"
BEGIN, END, PERIOD = 4.0, 11.0, 0.08
"""First and last instant that is shown, and the time between two frames [s]; played at real time."""
TRAIL = 1.5
"""Length of the orbit behind the mark [s]."""


def draw(path: Path) -> None:
    """Run the scene and write the moving picture.

    Args:
        path: File of the picture (.gif).
    """
    result = dt.Simulation(SCENE).run(duration=END)
    time = np.asarray(result.time)
    frames = [_frame(result, int(np.searchsorted(time, now))) for now in np.arange(BEGIN, END, PERIOD)]
    palette = frames[-1].quantize(colors=64, method=Image.Quantize.FASTOCTREE)
    small = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    duration = int(1000 * PERIOD)
    small[0].save(path, save_all=True, append_images=small[1:], duration=duration, loop=0, optimize=True)


def _frame(result: Any, now: int) -> Image.Image:
    with mpl.rc_context({"font.family": "DejaVu Sans", "font.size": 10}):
        figure = Figure(figsize=(7.2, 3.8), dpi=100)
        FigureCanvasAgg(figure)
        _draw_string(figure, result, now)
        _draw_orbit(figure, result, now)
        _say(figure, result, now)
        drawn = BytesIO()
        figure.savefig(drawn, format="png")
        return Image.open(drawn).convert("RGB")


def centre_line(result: Any, now: int) -> Array:
    """Points of the centre line [m], shape (400, 3): between the nodes a cubic by their tangents, as in the model."""
    nodes, tangent = np.asarray(result.string.position[now]), np.asarray(result.string.tangent[now])
    height = np.linspace(nodes[0, 2], nodes[-1, 2], 400)
    across = CubicHermiteSpline(nodes[:, 2], nodes[:, :2], tangent[:, :2] / tangent[:, 2:])(height)
    return np.concatenate([across, height[:, None]], axis=1)


def _seen(points: Array, shift: float) -> tuple[Array, Array]:
    """Points of the hole in an oblique view: across the page is depth, up is x, and y goes up to the right."""
    return -points[:, 2] + shift * points[:, 1], points[:, 0] + 0.35 * points[:, 1]


def _draw_string(figure: Figure, result: Any, now: int) -> None:
    axes = figure.add_axes((0.03, 0.16, 0.55, 0.62))
    radius = result.scene.hole.radius
    length = -result.string.position[0, 0, 2]
    shift = 2.2
    angle = np.linspace(0.0, 2.0 * np.pi, 100)
    for depth in np.linspace(0.0, length, 7):
        ring = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full_like(angle, -depth)], axis=1)
        axes.plot(*_seen(ring, shift), color=LIGHT, linewidth=1.0)
    for side in (-1.0, 1.0):
        axes.plot([0.0, length], [side * radius * 1.06] * 2, color=GREY, linewidth=1.0)
    axes.plot(*_seen(centre_line(result, now), shift), color=BLUE, linewidth=2.6)
    mark = result.marks.names.index(MARK)
    place = np.append(result.centre[now, mark], result.marks.position[now, mark, 2])[None]
    axes.plot(*_seen(place, shift), "o", color=VERMILION, markersize=7)
    figure_width, figure_height = figure.get_size_inches()
    enlarged = (0.62 * figure_height / 0.29) / (0.55 * figure_width / (length + 0.6))
    words = f"rod of {length:.0f} m, displacement across the hole drawn {enlarged:.0f} times as large"
    figure.text(0.03, 0.045, words, fontsize=9, color=GREY)
    axes.text(0.0, 0.125, "top drive", fontsize=9, color=GREY, ha="left")
    axes.text(length, 0.125, "bit", fontsize=9, color=GREY, ha="right")
    axes.set(xlim=(-0.3, length + 0.3), ylim=(-0.14, 0.15))
    axes.axis("off")


def _draw_orbit(figure: Figure, result: Any, now: int) -> None:
    axes = figure.add_axes((0.62, 0.10, 0.36, 0.68))
    mark = result.marks.names.index(MARK)
    clearance = result.scene.clearance_at(result.scene.string.marks[mark].distance_from_bit)
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    axes.plot(clearance * np.cos(angle), clearance * np.sin(angle), color=GREY, linewidth=1.2)
    axes.plot(0.0, 0.0, "+", color=INK, markersize=7)
    time = np.asarray(result.time)
    first = int(np.searchsorted(time, time[now] - TRAIL))
    axes.plot(*result.centre[first : now + 1, mark].T, color=BLUE, linewidth=1.4)
    axes.plot(*result.centre[now, mark], "o", color=VERMILION, markersize=8)
    axes.set(aspect="equal", xlim=(-0.1, 0.1), ylim=(-0.1, 0.1))
    axes.axis("off")
    figure.text(0.80, 0.045, f"{MARK}, seen along the hole", fontsize=9, color=GREY, ha="center")


def _say(figure: Figure, result: Any, now: int) -> None:
    time, onset = float(result.time[now]), result.whirl.onset
    weight, speed = result.weight_on_bit[now], result.rig.top_drive_speed[now] / (2.0 * np.pi)
    figure.text(0.03, 0.93, f"{time:4.1f} s", fontsize=14, fontweight="bold", color=INK)
    figure.text(0.15, 0.93, f"weight on bit {weight:.0f} N, rotation {speed:.1f} rev/s", fontsize=11, color=INK)
    offset = float(np.abs(result.centre[now]).max())
    if onset is not None and time >= onset.detected_s:
        words = (
            f"Whirl detected: it began at {onset.time_s:.1f} s at {onset.mark} (announced at {onset.detected_s:.1f} s)"
        )
        figure.text(0.03, 0.84, words, fontsize=11, fontweight="bold", color=VERMILION)
    elif offset > 0.002:
        figure.text(0.03, 0.84, "The rod buckles under its load", fontsize=11, color=INK)
    else:
        figure.text(0.03, 0.84, "The rod turns about its own axis", fontsize=11, color=INK)
