# SPDX-License-Identifier: Apache-2.0
"""Figures of a fit: the record with the draws over time, and the draws of the numbers against each other."""

import numpy as np
from matplotlib.figure import Figure

from drill_twin.report.figures.style import BLUE, LIGHT, VERMILION, laid_out, styled
from drill_twin_studies.fitting.posterior import Posterior
from drill_twin_studies.fitting.record import CHANNELS
from drill_twin_studies.goodness import HALF_WIDTH


def corner_figure(found: Posterior) -> Figure:
    """Histogram of the draws of each number, and below it a dot for each pair of numbers of a draw; in SI."""
    keys, columns = found.keys, found.draws.T
    with styled():
        figure = laid_out(1.0 + 2.4 * len(keys), f"{found.scene.name}: draws of the numbers, in SI")
        for (k, j), panel in np.ndenumerate(figure.subplots(len(keys), len(keys), sharex="col", squeeze=False)):
            panel.set(visible=j <= k, xlabel=keys[j] * (k == len(keys) - 1), ylabel=keys[k] * (j == 0 < k))
            if j == k:
                panel.hist(columns[k], 20, color=BLUE)
            else:
                panel.plot(columns[j], columns[k], ".", color=BLUE, markersize=2, alpha=0.3)
    return figure


def fit_figure(found: Posterior) -> Figure:
    """Record, 90 % band and best run over time, a panel for each channel; below it, its residual over the noise."""
    channels = list(found.measured)
    with styled():
        figure = laid_out(1.0 + 3.4 * len(channels), f"{found.scene.name}: the record and the draws")
        heights = {"height_ratios": [2.4, 1.0] * len(channels)}
        panels = figure.subplots(2 * len(channels), sharex=True, squeeze=False, gridspec_kw=heights)[:, 0]
        for axes, below, channel in zip(panels[::2], panels[1::2], channels, strict=True):
            low, high = found.band(channel)
            size, unit = found.scene.unit_system.in_unit(CHANNELS[channel].unit)
            measured, best = size * found.measured[channel], size * found.runs[channel][found.best_run]
            axes.fill_between(found.time, size * low, size * high, color=LIGHT, label="90 % band")
            axes.plot(found.time, measured, color=BLUE, linewidth=1.0, label="record")
            axes.plot(found.time, best, color=VERMILION, linewidth=1.0, label="best run")
            axes.set_ylabel(f"{channel} [{unit}]")
            fitted = found.goodness[channel]
            if found.window is not None:  # the phase of the series is not determined
                below.set_visible(False)
                continue
            below.plot(found.time, found.residual(channel) / fitted.noise, color=BLUE, linewidth=0.8)
            below.axhspan(-HALF_WIDTH, HALF_WIDTH, color=LIGHT)
            below.set_ylabel("residual / noise")
            below.set_title(f"rms {fitted.ratio:.3g}, from sample to sample {fitted.correlation:+.2f}", fontsize=9.5)
        panels[-1].set_xlabel("time [s]")
        panels[0].legend(loc="upper right", ncols=3)
    return figure
