# SPDX-License-Identifier: Apache-2.0
"""Figure of the conflict between two groups of published numbers: deviation of each set of parameters from both."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.figure import Figure

from drill_twin.report.figures.style import BLUE, GREY, INK, VERMILION, blank, head
from drill_twin_evidence.paper.runs.published import FREQUENCY, RATIO, Number
from drill_twin_evidence.paper.search.calibrate import FITTED, LARGEST, Loss

Point = tuple[float, float]
"""Deviations of the two groups, in units of 20 %: fast whirl, slow whirl."""

SLOW_FROM = 150.0
"""Least load of the paper's slow whirl [N]."""


def groups() -> tuple[tuple[Number, ...], tuple[Number, ...]]:
    """Fitted frequencies and ratios: fast whirl (half the rotation and more) and slow whirl (a seventh of it)."""
    whirl = [number for number in FITTED if number.what in (FREQUENCY, RATIO)]
    slow = tuple(number for number in whirl if number.weight_on_bit >= SLOW_FROM)
    return tuple(number for number in whirl if number not in slow), slow


def point(loss: Loss) -> Point:
    """Root mean square deviation of each group."""
    fast, slow = (
        math.sqrt(sum(loss.deviations[number.name] ** 2 for number in group) / len(group)) for group in groups()
    )
    return fast, slow


def front(points: Sequence[Point]) -> list[Point]:
    """Pareto front, from the best at the first to the best at the second."""
    found: list[Point] = []
    for fast, slow in sorted(set(points)):
        if not found or slow < found[-1][1]:
            found.append((fast, slow))
    return found


def draw_trade_off(tried: Sequence[Loss], best: Loss) -> Figure:
    """Figure of every set tried, the Pareto front and the set found."""
    points = [point(loss) for loss in tried]
    best_of = front(points)
    figure = blank(5.8)
    head(figure, "What one set of parameters can do for the whirl at low and at high load")
    panel = figure.add_axes((0.09, 0.17, 0.86, 0.69))
    panel.plot(*zip(*points, strict=True), "o", color=GREY, markersize=3.5, alpha=0.6, label="a set tried")
    panel.plot(*zip(*best_of, strict=True), "o-", color=BLUE, drawstyle="steps-post", label="none is better at both")
    panel.plot(*point(best), "D", color=VERMILION, markersize=9, label="the set found, by all fitted numbers")
    for line in (panel.axhline, panel.axvline):
        line(1.0, color=INK, linestyle=":", linewidth=1.0)
    fast, slow = ("; ".join(number.name for number in group) for group in groups())
    panel.set_xlabel(f"{fast}\noff by, in 20 % (root mean square)")
    panel.set_ylabel(f"{slow}\noff by, in 20 % (root mean square)")
    panel.set_xlim(0.0, LARGEST + 0.2)
    panel.set_ylim(0.0, LARGEST + 0.4)
    ticks = [float(tick) for tick in range(int(LARGEST) + 1)]
    for axis in (panel.xaxis, panel.yaxis):  # a deviation counts as at most LARGEST
        axis.set_ticks(ticks, [f"{tick:g}" if tick < LARGEST else f"≥ {tick:g}" for tick in ticks])
    panel.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3)
    return figure
