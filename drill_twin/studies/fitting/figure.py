# SPDX-License-Identifier: Apache-2.0
"""Figure of a fit: the record against the band of the draws."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drill_twin.studies.fitting.posterior import Posterior

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def fit_figure(found: Posterior) -> Figure:
    """Record, 90 % band and best run over time, a panel for each channel."""
    from drill_twin.report.figures.style import BLUE, LIGHT, VERMILION, laid_out, styled
    from drill_twin.studies.fitting.record import CHANNELS

    channels = list(found.measured)
    with styled():
        figure = laid_out(1.0 + 2.4 * len(channels), f"{found.scene.name}: the record and the draws")
        panels = figure.subplots(len(channels), sharex=True, squeeze=False)[:, 0]
        for axes, channel in zip(panels, channels, strict=True):
            low, high = found.band(channel)
            axes.fill_between(found.time, low, high, color=LIGHT, label="90 % band")
            axes.plot(found.time, found.measured[channel], color=BLUE, linewidth=1.0, label="record")
            axes.plot(found.time, found.runs[channel][found.best_run], color=VERMILION, linewidth=1.0, label="best run")
            axes.set_ylabel(f"{channel} [{CHANNELS[channel].unit}]")
        panels[-1].set_xlabel("time [s]")
        panels[0].legend(loc="upper right", ncols=3)
    return figure
