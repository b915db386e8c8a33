# SPDX-License-Identifier: Apache-2.0
"""Fit for people: its table, and the record beside the runs."""

from collections.abc import Iterator

from matplotlib.figure import Figure
from rich.text import Text

from drill_twin.core.table import Table
from drill_twin.report.figures.style import BLUE, LIGHT, VERMILION, laid_out, styled
from drill_twin_studies.fitting.posterior import HELD, Posterior, shown_number
from drill_twin_studies.fitting.record import CHANNELS
from drill_twin_studies.goodness import HALF_WIDTH
from drill_twin_studies.goodness import table as goodness_table


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


def shown(found: Posterior) -> Iterator[Table | Text | str]:
    """Table of the numbers with their intervals, and what the record does not determine."""
    if found.unexplained:
        yield Text(f"{found.unexplained}; intervals count with what is left, not with what is hidden in it", "bold red")
    rows = []
    for key in found.ranges:
        size, unit = shown_number(key, found.scene)
        low, high = found.intervals[key]
        values = found.best[key], low, found.median(key), high
        rows.append((f"{key} [{unit}]" if unit else key, *(f"{size * value:.4g}" for value in values)))
    yield Table(
        ("number", "best", "low", "median", "high"),
        rows,
        title=f"{found.scene.name}: {len(found.values)} runs, intervals of 90 %",
        right=(1, 2, 3, 4),
    )
    yield HELD
    if found.sampling.power < 1.0:
        yield Text("the draws are still wider than the record allows; more --rounds narrow the intervals", "yellow")
    for line in found.undetermined:
        yield f"not determined: {line}"
    yield from found.of_law
    yield goodness_table(found.goodness)
    yield from found.record.notes
