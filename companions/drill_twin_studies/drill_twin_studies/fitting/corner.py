# SPDX-License-Identifier: Apache-2.0
"""Corner of a fit: the draws of its numbers, alone and against each other."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from drill_twin.core.arrays import Array
from drill_twin.report.figures.style import BLUE, laid_out, styled


def corner_figure(title: str, keys: Sequence[str], draws: Array) -> Figure:
    """Histogram of the draws of each number, and below it a dot for each pair of numbers of a draw.

    Args:
        title: Words above the panels.
        keys: Keys of the numbers.
        draws: Draws of equal weight, shape (N, d).
    """
    with styled():
        figure = laid_out(1.0 + 2.4 * len(keys), title)
        for (k, j), panel in np.ndenumerate(figure.subplots(len(keys), len(keys), sharex="col", squeeze=False)):
            panel.set(visible=j <= k, xlabel=keys[j] * (k == len(keys) - 1), ylabel=keys[k] * (j == 0 < k))
            if j == k:
                panel.hist(draws[:, k], 20, color=BLUE)
            else:
                panel.plot(draws[:, j], draws[:, k], ".", color=BLUE, markersize=2, alpha=0.3)
    return figure
