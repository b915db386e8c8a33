# SPDX-License-Identifier: Apache-2.0
"""Figure of an operating map: regimes, both boundaries, safe window, as on its page."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from drill_twin.maps.operating_map import OperatingMap
from drill_twin.maps.page import grows
from drill_twin.maps.regimes import REGIMES
from drill_twin.scene.load import parse_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#009e73", "#f0e442", "#56b4e9", "#e69f00", "#d55e00", "#cc79a7", "#666666")
"""Colours of the regimes, in their order (Okabe and Ito 2008)."""
_KILO = 5000.0  # N; ranges above are in kN


def map_figure(found: OperatingMap) -> Figure:
    """Regimes over weight on bit and speed, the runs, the boundaries and the safe window."""
    from matplotlib.patches import Patch

    from drill_twin.report.figures.style import laid_out, styled

    with styled():
        figure = laid_out(5.6, f"{found.name}: motion after {found.duration:g} s, {len(found.records)} runs")
        axes = figure.add_subplot()
        unit, name = (1000.0, "kN") if found.plane.weight.high >= _KILO else (1.0, "N")
        axes.set(xlabel=f"weight on bit [{name}]", ylabel="speed [rev/s]")
        axes.grid(visible=False)
        _draw(axes, found, unit)
        there = np.unique(found.regimes).tolist()
        regimes = [Patch(color=COLOURS[code], label=REGIMES[code].value) for code in there]
        handles = [*regimes, *axes.get_legend_handles_labels()[0]]
        figure.legend(handles=handles, loc="outside lower left", ncols=4)
    return figure


def _draw(axes: Axes, found: OperatingMap, unit: float) -> None:
    from matplotlib.collections import LineCollection
    from matplotlib.colors import BoundaryNorm, ListedColormap

    plane, scale = found.plane, np.array([unit, math.tau])
    (left, low), (right, high) = (np.array(plane.command(corner)) / scale for corner in ((0, 0), (plane.steps,) * 2))
    half = np.array([right - left, high - low]) / plane.steps / 2.0
    axes.imshow(
        found.regimes.T, origin="lower", aspect="auto", interpolation="nearest", cmap=ListedColormap(COLOURS),
        norm=BoundaryNorm(np.arange(len(COLOURS) + 1) - 0.5, len(COLOURS)),
        extent=(left - half[0], right + half[0], low - half[1], high + half[1]),
    )  # fmt: skip
    lines = [("whirl begins from rest", found.whirls, "-", 2.2)]
    if found.has_second_boundary:
        lines.append(("an existing whirl dies", found.keeps_whirling, "--", 1.8))
    if len(found.growth):
        lines.append(("linear string: growth 0", grows(found), ":", 1.8))
    for label, flags, style, width in lines:
        segments = [np.array(ends) / scale for ends in found.lines(flags)]
        colour = "#0072b2" if style == ":" else "black"
        axes.add_collection(LineCollection(segments, colors=colour, linestyles=style, linewidths=width, label=label))
    runs = np.array([plane.command(key.node) for key in found.records if key.origin is None]) / scale
    axes.plot(*runs.T, ".", color="black", markersize=1.6, alpha=0.6, label="runs")
    if found.window is not None:
        (load, most), (slow, fast) = (np.array(span) / by for span, by in zip(found.window, scale, strict=True))
        x, y = np.array([load, most, most, load, load]), np.array([slow, slow, fast, fast, slow])
        axes.plot(x, y, color="white", linewidth=4.0)
        axes.plot(x, y, color="#00432f", linewidth=2.0, label="safe window")
    rig = parse_scene(found.scene).rig
    if found.contains(rig.weight_on_bit.value, rig.rotation.value):
        place = np.array([rig.weight_on_bit.value, rig.rotation.value]) / scale
        axes.plot(*place, "o", color="black", markerfacecolor="white", label="set-point of the scene")
    axes.set(xlim=(left, right), ylim=(low, high))
