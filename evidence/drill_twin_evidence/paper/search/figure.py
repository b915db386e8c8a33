# SPDX-License-Identifier: Apache-2.0
"""Figure of the search: the exclusion map."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from drill_twin.core.arrays import Array
from drill_twin.report.figures.style import INK, LIGHT, blank, head
from drill_twin_evidence.paper.runs.published import Number
from drill_twin_evidence.paper.search.exclusion import Exclusion
from drill_twin_evidence.paper.search.goals import LOOSE, STRICT
from drill_twin_evidence.paper.search.readings import NEAR, NUMBERS

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
