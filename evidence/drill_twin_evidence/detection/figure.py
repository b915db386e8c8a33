# SPDX-License-Identifier: Apache-2.0
"""Curves of the errors of the analyzer and of the plain detector."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drill_twin.report.figures.style import laid_out, styled
from drill_twin_evidence.detection.frozen.curves import AXES, GROWTH, NOISE, Curves


def curves_figure(curves: Mapping[str, Curves]) -> Figure:
    """False alarms over noise, delay over growth, share of ellipses called whirl; dashed: the plain detector."""
    with styled():
        figure = laid_out(4.6, "Errors of the analyzer (full lines) and of the plain detector (dashed)")
        alarms, delay, whirl = figure.subplots(1, 3)
        for style, one in zip(("-", "--"), curves.values(), strict=False):
            for index, (colour, rates) in enumerate(one.alarms.items()):
                label = "white noise" if colour == 0.0 else "1/f noise"
                _line(alarms, 100.0 * np.array(NOISE), rates, style, index, label)
            for index, (noise, found) in enumerate(one.delay.items()):
                _line(delay, GROWTH, found, style, index, f"noise {100 * noise:g} %")
            for index, (hole, shares) in enumerate(one.whirl.items()):
                _line(whirl, AXES, 100.0 * np.array(shares), style, index, f"{hole} hole")
        alarms.set(xlabel="noise [% of the clearance]", ylabel="alarms an hour", title="Noise alone")
        delay.set(xlabel="e-foldings in a revolution", ylabel="announced after the onset [rev]", title="Growing orbits")
        delay.set_xscale("log")
        whirl.set(xlabel="ratio of the half axes", ylabel="called whirl [%]", title="Ellipses")
        for panel in (alarms, delay, whirl):
            panel.legend(fontsize=8)
        return figure


def _line(panel: Any, x: Any, y: Any, style: str, index: int, label: str) -> None:
    panel.plot(x, y, style, color=f"C{index}", marker="o", markersize=3, label=label if style == "-" else None)
