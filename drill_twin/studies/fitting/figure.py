# SPDX-License-Identifier: Apache-2.0
"""Figure of a fit: the record against the band of the draws."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drill_twin.studies.fitting.posterior import Posterior

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def fit_figure(found: Posterior) -> Figure:
    """Record, 90 % band and best run over time, a panel for each channel."""
    from matplotlib.figure import Figure

    from drill_twin.studies.fitting.record import CHANNELS

    channels = list(found.measured)
    figure = Figure(figsize=(11.0, 1.0 + 2.6 * len(channels)), layout="constrained")
    for axes, channel in zip(figure.subplots(len(channels), squeeze=False)[:, 0], channels, strict=True):
        low, high = found.band(channel)
        best = found.runs[channel][found.best_run]
        axes.fill_between(found.time, low, high, color="0.85", label="90 % band")
        axes.plot(found.time, found.measured[channel], color="C0", linewidth=1.0, label="record")
        axes.plot(found.time, best, color="C1", linewidth=1.0, label="best run")
        axes.set_ylabel(f"{channel} [{CHANNELS[channel].unit}]")
        axes.grid(visible=True, alpha=0.3)
    axes.set_xlabel("time [s]")
    figure.axes[0].legend(loc="upper right", ncols=3)
    return figure
