# SPDX-License-Identifier: Apache-2.0
"""Prediction of the start-up of Well B with the bit at 2,235 m, from the fit at 1,714 m, before anyone compares."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from drill_twin.api import Ensemble, Posterior
from drill_twin.core.arrays import Array
from drill_twin.scene.overrides import full_key
from drill_twin_evidence.validation.comparison import Comparison
from drill_twin_evidence.validation.well_b import (
    DEEPER,
    LAST,
    RATE,
    RPM,
    Channels,
    columns,
    comparisons,
    played,
    scene_at,
    torque_record,
)  # fmt: skip
from drill_twin_studies.fitting.posterior import predictive_band
from drill_twin_studies.fitting.sampling import weighted_quantile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DURATION = 60.0
MOST = 8
"""Draws that are run, those of the largest weight."""
NAMES = {"motor_torque": "motor torque [kN m]", "bit_speed": "downhole speed [rpm]"}
UNITS = {"motor_torque": 1e-3, "bit_speed": 1.0 / RPM}


class Band(NamedTuple):
    """Median and 90 % band of a channel, each of shape (T,)."""

    low: Array
    median: Array
    high: Array


def predict(folder: Path, found: Posterior) -> tuple[Array, Mapping[str, Band]]:
    """Time [s] and bands of torque [kN m] and downhole speed [rpm] under the draws of a fit.

    The band holds the draws and the error that the best of them had in the fit; that of the speed is the same share of
    its deviation.

    Args:
        folder: Folder of the record with the set-point.
        found: The fit at 1,714 m.
    """
    chosen = np.argsort(found.sampling.weights)[::-1][:MOST]
    weights = found.sampling.weights[chosen] / found.sampling.weights[chosen].sum()
    vary = {full_key(key, found.scene): found.values[chosen, i].tolist() for i, key in enumerate(found.keys)}
    error = found.runs["motor_torque"][found.best_run] - found.measured["motor_torque"]
    share = float(np.std(error) / np.std(found.measured["motor_torque"]))
    stamps, speed = np.loadtxt(folder / "B2235_speed_set_point.csv", delimiter=",").T
    time = np.arange(0.05, DURATION, 0.05)
    with TemporaryDirectory() as place:
        overrides = scene_at(DEEPER) | played(time, np.interp(time, stamps, speed) * RPM, Path(place))
        runs = Ensemble("well_b", vary, zipped=True, overrides=overrides).run(
            DURATION, outputs="channels", mark_rate=RATE
        )
    bands = {}
    for channel, unit in UNITS.items():
        alive = np.isfinite(runs[channel]).all(axis=1)
        values, kept = unit * runs[channel][alive], weights[alive] / weights[alive].sum()
        low, high = predictive_band(values, kept, share * float(values.std()), 0.9)
        bands[channel] = Band(low, weighted_quantile(values, kept, 0.5), high)
    return runs["time"], bands


def verdict(folder: Path, table: Path) -> list[Comparison]:
    """The prediction as it was written down, and the published model, beside the record at 2,235 m over 0 to 45 s.

    Args:
        folder: Folder of the record.
        table: Bands that `csv_text` wrote before the record was opened.
    """
    found = np.loadtxt(table, delimiter=",", skiprows=1)
    time, low, torque, high, _, speed, _ = found[found[:, 0] <= LAST].T
    measured = torque_record(folder, DEEPER).at("motor_torque", time)
    published = torque_record(folder, DEEPER, "sim").at("motor_torque", time)
    bit = np.interp(time, *columns(folder, f"B{DEEPER:.0f}_bit_model.csv"))
    inside = float(np.mean((low <= 1e-3 * measured) & (1e-3 * measured <= high)))
    rows = [Comparison("share of the torque in the 90 % band [-]", "prediction", 0.9, inside, math.inf)]
    for name, run in {
        "twin": Channels(DEEPER, time, measured, 1e3 * torque, speed * RPM),
        "published model": Channels(DEEPER, time, measured, published, bit * RPM),
    }.items():
        rows += [replace(row, what=f"{name}: {row.what}") for row in comparisons(folder, run, "prediction")]
    return rows


def csv_text(time: Array, bands: Mapping[str, Band]) -> str:
    """Table of the bands: a row for each sample."""
    header = ["time [s]", *(f"{NAMES[name]} {part}" for name in bands for part in ("5 %", "median", "95 %"))]
    columns = [time, *(column for band in bands.values() for column in band)]
    rows = [",".join(f"{value:.4g}" for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([",".join(header), *rows]) + "\n"


def figure(time: Array, bands: Mapping[str, Band]) -> Figure:
    """Bands over time."""
    from drill_twin.report.figures.style import BLUE, laid_out, styled

    with styled():
        drawn = laid_out(6.0, f"Well B at {DEEPER:g} m: a prediction, before any comparison")
        panels = drawn.subplots(len(bands), sharex=True)
        for axes, (name, band) in zip(panels, bands.items(), strict=True):
            axes.fill_between(time, band.low, band.high, color=BLUE, alpha=0.2, linewidth=0, label="90 % band")
            axes.plot(time, band.median, color=BLUE, label="median")
            axes.set_ylabel(NAMES[name])
            axes.set_xlim(0.0, DURATION)
        panels[0].legend(loc="upper left", ncols=2)
        panels[-1].set_xlabel("time [s]")
        return drawn
