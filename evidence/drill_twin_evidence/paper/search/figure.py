# SPDX-License-Identifier: Apache-2.0
"""Figures of the search: the exclusion map, and the posterior of what the paper leaves open."""

from __future__ import annotations

from textwrap import wrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from drill_twin.base.arrays import Array
from drill_twin.report.figures.style import BLUE, INK, LIGHT, blank, head
from drill_twin_evidence.paper.runs.published import Number
from drill_twin_evidence.paper.search.assumptions import LOOSE, STRICT
from drill_twin_evidence.paper.search.exclusion import Exclusion
from drill_twin_evidence.paper.search.posterior import SOUGHT, Posterior
from drill_twin_evidence.paper.search.readings import NEAR, NUMBERS
from drill_twin_evidence.paper.search.space import FREE

BOUNDS = (0.0, 0.5, NEAR, 1.5, 2.0, 3.0, 8.01)
COLOURS = ("#2166ac", "#92c5de", "#fddbc7", "#f4a582", "#d6604d", "#8c1127")
"""Blue: met; red: excluded, the darker the farther off."""


def draw_exclusion(found: Exclusion) -> Figure:
    """Map of the pairs: below the diagonal with all assumptions kept, above with none."""
    figure = blank(9.2)
    head(figure, "Which published numbers one set of parameters can meet together")
    panel = figure.add_axes((0.25, 0.26, 0.6, 0.65))
    count = len(NUMBERS)
    table = np.where(np.tri(count, k=-1, dtype=bool), found.least[STRICT], found.least[LOOSE])
    np.fill_diagonal(table, np.nan)
    colours = ListedColormap(list(COLOURS)).with_extremes(bad=LIGHT)
    image = panel.imshow(np.minimum(table, 8.0), cmap=colours, norm=BoundaryNorm(BOUNDS, len(COLOURS)))
    _write(panel, table, found.least)
    names = [_short(number) for number in NUMBERS]
    panel.set_xticks(range(count), names, rotation=60, ha="right", rotation_mode="anchor", fontsize=9)
    panel.set_yticks(range(count), names, fontsize=9)
    panel.tick_params(length=0)
    panel.grid(visible=False)
    panel.set_title("above the diagonal: any reading, any choice; below it: all assumptions kept", fontsize=10)
    bar = figure.colorbar(image, cax=figure.add_axes((0.88, 0.26, 0.02, 0.65)), spacing="uniform", ticks=BOUNDS[:-1])
    bar.set_label("least misfit found, the larger of the two, in units of 20 % (met up to 1)")
    figure.text(
        0.02, 0.015,
        f"{found.sets} sets, {found.runs} runs. On the diagonal: the number alone, any reading and choice. "
        "A pair that was not met may still be met by a set that was not tried.",
        fontsize=9, color=INK,
    )  # fmt: skip
    return figure


SHOWN = 6
"""Numbers of a posterior that are drawn: those that it determines best."""


def draw_posterior(found: Posterior) -> Figure:
    """Draws of the numbers that the paper determines best, each alone and in pairs, on their logarithmic scales."""
    figure = blank(9.6)
    head(figure, "What the published numbers say about the bench, all assumptions kept")
    order = sorted(range(len(SOUGHT)), key=found.width)[:SHOWN]
    panels = figure.subplots(SHOWN, SHOWN, gridspec_kw={
        "left": 0.11, "right": 0.98, "bottom": 0.13, "top": 0.92, "hspace": 0.08, "wspace": 0.08})  # fmt: skip
    for (i, j), panel in np.ndenumerate(panels):
        if j > i:
            panel.axis("off")
            continue
        x, y = (_logarithm(found, order[k]) for k in (j, i))
        low, high = _bounds(order[j])
        if i == j:
            panel.hist(x, bins=list(np.linspace(low, high, 21)), weights=found.weights, color=BLUE)
            panel.set_yticks([])
        else:
            panel.scatter(x, y, 2.0, color=LIGHT)
            panel.scatter(x, y, 1500.0 * found.weights, color=BLUE, alpha=0.5, linewidths=0.0)
            panel.set_ylim(*_bounds(order[i]))
        panel.set_xlim(low, high)
        panel.grid(visible=False)
        panel.tick_params(labelsize=8, labelbottom=i == SHOWN - 1, labelleft=j == 0 and i > 0)
        if i == SHOWN - 1:
            panel.set_xlabel(_label(order[j]), fontsize=8)
        if j == 0 and i > 0:
            panel.set_ylabel(_label(order[i]), fontsize=8)
    figure.text(
        0.02, 0.015,
        f"{len(found.shares)} draws, the area of each its weight, worth {found.effective:.0f} of equal weight; "
        "the axes are the bounds of the prior, powers of ten.",
        fontsize=9, color=INK,
    )  # fmt: skip
    return figure


def _logarithm(found: Posterior, k: int) -> Array:
    low, high = _bounds(k)
    return np.asarray(low + found.shares[:, k] * (high - low))


def _bounds(k: int) -> tuple[float, float]:
    parameter = FREE[SOUGHT[k]]
    return float(np.log10(parameter.low)), float(np.log10(parameter.high))


def _label(k: int) -> str:
    parameter = FREE[SOUGHT[k]]
    unit = f" [{parameter.unit}]" if parameter.unit else ""
    return "\n".join(wrap(f"log10 {parameter.name}{unit}", 22))


def _write(panel: Axes, table: Array, least: Array) -> None:
    for i, j in np.ndindex(table.shape):
        value = least[LOOSE, i, i] if i == j else table[i, j]
        dark = i != j and (value >= 2.0 or value < 0.5)
        text = f"{value:.1f}" if np.isfinite(value) else "-"
        panel.text(j, i, text, ha="center", va="center", fontsize=8, color="white" if dark else INK)


def _short(number: Number) -> str:
    mark = (
        f", {number.mark.replace('_', '-')}" if number.mark else f", {number.weight_on_bit:g} N, {number.speed:g} rev/s"
    )
    unit = f" {number.unit}".rstrip()
    return f"{number.what} {number.value:g}{unit}{mark}".replace("largest displacement", "displacement").replace(
        "whirl frequency", "whirl"
    )
