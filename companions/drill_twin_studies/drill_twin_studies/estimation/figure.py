# SPDX-License-Identifier: Apache-2.0
"""Estimates for people: table, line and figure of numbers and virtual sensors with their bands; plain types."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from drill_twin.core.table import Table
from drill_twin.core.units.system import UnitSystem
from drill_twin.scene import Scene
from drill_twin_studies.estimation.estimate import HELD, SHARE, Estimate, shown_unit
from drill_twin_studies.fitting.posterior import of_law, shown_number
from drill_twin_studies.fitting.record import Record
from drill_twin_studies.goodness import table as goodness_table


def estimate_figure(found: Sequence[Estimate], record: Record, units: UnitSystem) -> Any:
    """Figure: mean and band of each number and virtual sensor over time; below, measured less predicted and chi-square.

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


def shown(found: Estimate, scene: Scene, troubles: Mapping[str, int]) -> Iterator[Table | str]:
    """Alarm, table of numbers and sensors, and what the record does not tell."""
    yield from filter(None, (found.alarm, found.remembered))
    rows = []
    known = {name: band for name, band in found.sensors.items() if name not in found.withheld}
    for name, band in {**found.numbers, **known}.items():
        size, unit = shown_unit(name, scene.unit_system) if name in found.sensors else shown_number(name, scene)
        mean, low, high = (f"{size * value:.4g}" for value in (band.mean, band.low, band.high))
        rows.append((f"{name} [{unit}]" if unit else name, mean, f"{size * band.deviation:.2g}", low, high))
    title = f"{scene.name} at {found.time:g} s"
    yield Table(("", "mean", "deviation", "low", "high"), rows, title=title, right=(1, 2, 3, 4))
    for reason in dict.fromkeys(found.withheld.values()):
        yield f"{', '.join(name for name, why in found.withheld.items() if why == reason)}: withheld, {reason}"
    for key, share in found.untold.items():
        yield f"{key}: the record does not tell it, its band covers {share:.0%} of its range"
    yield from of_law(found.numbers, scene)
    yield goodness_table(found.goodness)
    yield HELD
    yield line(found)
    if troubles:
        yield ", ".join(f"{count} {kind}" for kind, count in troubles.items())


def line(found: Estimate) -> str:
    """Time, chance of whirl and alarm in a line."""
    chance = "" if found.chance != found.chance else f", whirl soon {found.chance:.0%}"
    return f"{found.time:6.1f} s: whirls now {found.whirls:.0%}{chance}" + (f"; {found.alarm}" if found.alarm else "")


def plain(found: Estimate) -> dict[str, Any]:
    """Plain types for JSON."""
    plain = asdict(found)
    del plain["frames"]
    plain["goodness"] = {name: one.to_dict() for name, one in found.goodness.items()}
    return plain | {"alarm": found.alarm, "remembered": found.remembered}
