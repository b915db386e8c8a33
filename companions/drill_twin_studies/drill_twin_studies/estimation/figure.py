# SPDX-License-Identifier: Apache-2.0
"""Figure of estimates over a record: numbers and virtual sensors with their bands, and what is not explained."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from drill_twin.core.units.system import UnitSystem
from drill_twin_studies.estimation.estimate import SHARE, Estimate, shown_unit
from drill_twin_studies.fitting.record import Record

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def estimate_figure(found: Sequence[Estimate], record: Record, units: UnitSystem) -> Figure:
    """Mean and band of each number and virtual sensor over time; below, measured less predicted: rms and chi-square.

    A sensor that is 0 throughout, as the wall force of a string that never touches, has no panel.

    Args:
        found: Estimates in the order of their times.
        record: The record that they follow; a channel of a sensor's name is drawn beside it.
        units: Units of the sensors.
    """
    from drill_twin.report.figures.style import BLUE, LIGHT, VERMILION, laid_out, styled, unbridged

    time = np.array([one.time for one in found])
    names = [(name, 1.0, "SI") for name in found[0].numbers]
    moved = (name for name in found[0].sensors if any(np.nan_to_num(one.sensors[name].mean) for one in found))
    names += [(name, *shown_unit(name, units)) for name in moved]
    channels = sorted({name for one in found for name in one.misfit})
    with styled():
        figure = laid_out(1.0 + 1.7 * (len(names) + 2), "Estimates over the record")
        panels = figure.subplots(len(names) + 2, sharex=True, squeeze=False)[:, 0]
        for axes, (name, size, unit) in zip(panels, names, strict=False):
            bands = [one.numbers.get(name) or one.sensors[name] for one in found]
            low, mean, high = (
                size * np.array([getattr(band, part) for band in bands]) for part in ("low", "mean", "high")
            )
            axes.fill_between(time, low, high, color=LIGHT, label=f"{SHARE:.0%} of the members")
            axes.plot(time, mean, color=VERMILION, marker=".", linewidth=1.2, label="mean at the end of a window")
            if name in record.series:
                times, values = record.series[name]
                axes.plot(*unbridged(times, size * values), color=BLUE, linewidth=0.8, label="record")
            axes.set_ylabel(f"{name.rpartition('.')[2].replace('_', ' ')} [{unit}]")
        for name in channels:
            panels[-2].plot(time, [one.misfit.get(name, np.nan) for one in found], label=name.replace("_", " "))
            chi_square = [one.goodness[name].chi_square for one in found]
            panels[-1].semilogy(time, chi_square, label=name.replace("_", " "))
        panels[-2].set_ylabel("misfit [-]")
        panels[-2].set_title("rms of measured less predicted, over the largest value", fontsize=9.5)
        panels[-1].set_ylabel("chi-square [-]")
        panels[-1].set_title("square of measured less predicted, over the predicted one; last 20 windows", fontsize=9.5)
        panels[-1].set_xlabel("time [s]")
        for axes in (panels[0], panels[-2], panels[-1]):
            if axes.get_legend_handles_labels()[0]:
                axes.legend(loc="upper right", ncols=3)
    return figure
