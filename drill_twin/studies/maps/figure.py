# SPDX-License-Identifier: Apache-2.0
"""Figure of an operating map: regimes, what is not known, both boundaries, safe windows, as on its page."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from drill_twin.core.arrays import Array
from drill_twin.scene.load import parse_scene
from drill_twin.studies.maps.operating_map import OperatingMap
from drill_twin.studies.maps.picture import WINDOW_COLOUR, boundaries
from drill_twin.studies.maps.regimes import COLOURS, REGIMES, Regime

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_KILO = 5000.0  # N; ranges above are in kN


def map_figure(found: OperatingMap) -> Figure:
    """Regimes over speed and weight on bit, the runs, the boundaries and the safe windows."""
    from matplotlib.patches import Patch

    from drill_twin.report.figures.style import laid_out, styled

    with styled():
        figure = laid_out(5.6, f"{found.name}: {found.said_runs}")
        axes = figure.add_subplot()
        unit, name = (1000.0, "kN") if found.plane.weight.high >= _KILO else (1.0, "N")
        axes.set(xlabel="speed [rev/s]", ylabel=f"weight on bit [{name}]")
        axes.grid(visible=False)
        _draw(axes, found, unit)
        there = np.unique(found.regimes).tolist()
        regimes = [Patch(color=COLOURS[code], label=REGIMES[code].value) for code in there]
        if not found.known.all():
            regimes.append(Patch(facecolor="white", edgecolor="black", hatch="///", label="not known, nearest run"))
        handles = [*regimes, *axes.get_legend_handles_labels()[0]]
        figure.legend(handles=handles, loc="outside lower left", ncols=4)
    return figure


def _draw(axes: Axes, found: OperatingMap, unit: float) -> None:
    from matplotlib.collections import LineCollection
    from matplotlib.colors import BoundaryNorm, ListedColormap

    plane, scale = found.plane, np.array([unit, math.tau])

    def shown(points: ArrayLike) -> Array:
        """Speed and weight on bit as on the axes, from those in SI the other way round, shape (..., 2)."""
        return np.asarray((np.asarray(points, float) / scale)[..., ::-1])

    (left, low), (right, high) = shown([plane.command((0, 0)), plane.command((plane.steps,) * 2)]).tolist()
    half = np.array([right - left, high - low]) / plane.steps / 2.0
    axes.imshow(
        found.regimes, origin="lower", aspect="auto", interpolation="nearest", cmap=ListedColormap(COLOURS),
        norm=BoundaryNorm(np.arange(len(COLOURS) + 1) - 0.5, len(COLOURS)),
        extent=(left - half[0], right + half[0], low - half[1], high + half[1]),
    )  # fmt: skip
    if not found.known.all():
        speeds, weights = (np.linspace(*ends, plane.steps + 1) for ends in ((left, right), (low, high)))
        middles = [0.5 * (nodes[1:] + nodes[:-1]) for nodes in (speeds, weights)]
        axes.contourf(*middles, ~found.known, levels=[0.5, 1.5], colors="none", hatches=["///"])
    for line in boundaries(found):
        segments = [shown(ends) for ends in line.segments]
        axes.add_collection(
            LineCollection(segments, colors=line.colour, linestyles=line.style, linewidths=line.width, label=line.label)
        )
    for label, failed, style, size in (("runs", False, ".", 1.6), ("", True, "x", 5.0)):
        runs = [plane.command(node) for node, made in found.runs_at_nodes.items()
                if (made[0].regime is Regime.FAILED) == failed]  # fmt: skip
        if runs:
            axes.plot(*shown(runs).T, style, color="white" if failed else "black", markersize=size, label=label)
    for number, ((load, most), (slow, fast)) in enumerate(found.windows):
        x, y = shown([(load, slow), (most, slow), (most, fast), (load, fast), (load, slow)]).T
        axes.plot(x, y, color="white", linewidth=4.0)
        axes.plot(x, y, color=WINDOW_COLOUR, linewidth=2.0, label="" if number else "safe windows")
    rig = parse_scene(found.scene).rig
    if found.contains(rig.weight_on_bit.value, rig.rotation.value):
        place = shown([rig.weight_on_bit.value, rig.rotation.value])
        axes.plot(*place, "o", color="black", markerfacecolor="white", label="set-point of the scene")
    axes.set(xlim=(left, right), ylim=(low, high))
