# SPDX-License-Identifier: Apache-2.0
"""Confusion matrices of the motion states."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from drill_twin.report.figures.style import INK, laid_out, styled
from drill_twin_evidence.detection.measure import Result
from drill_twin_evidence.detection.scoring import STATES, macro_f1

_SHORT = {
    "rotation about a fixed axis": "fixed axis",
    "forward whirl": "forward",
    "rolling along the wall": "rolling",
    "second bending": "2nd bending",
    "irregular": "irregular",
    "backward whirl": "reverse",
    "spiral": "spiral",
    "creeping along the wall": "creeping",
    "striking the wall": "impacts",
}


def confusion_figure(result: Result) -> Figure:
    """Confusion matrices of the states of the string, each row normalised: kinematic and simulated."""
    with styled():
        figure = laid_out(5.2, "True against found motion states")
        panels = figure.subplots(1, 2)
        for panel, score, name in zip(
            panels, (result.kinematic, result.simulated), ("kinematic signals", "simulated runs"), strict=True
        ):
            _matrix(panel, score.string, f"{name}: macro-F1 {macro_f1(score.string):.3f}")
        panels[1].set_ylabel("")
        return figure


def _matrix(panel: Axes, confusion: NDArray[np.int64], title: str) -> None:
    places = [STATES.index(state) for state in _SHORT]
    counts = confusion[np.ix_(places, places)].astype(float)
    share = counts / np.maximum(confusion[places].sum(axis=1, keepdims=True), 1)
    panel.imshow(share, cmap="Blues", vmin=0.0, vmax=1.0)
    for (row, column), value in np.ndenumerate(share):
        if value >= 5e-4:
            panel.text(
                column, row, f"{100 * value:.1f}", ha="center", va="center", fontsize=8.5,
                color="white" if value > 0.6 else INK,
            )  # fmt: skip
    names = list(_SHORT.values())
    panel.set_xticks(range(len(names)), names, rotation=40, ha="right", fontsize=9)
    panel.set_yticks(range(len(names)), names, fontsize=9)
    panel.set_xlabel("found [% of the true time]")
    panel.set_ylabel("true")
    panel.grid(visible=False)
    panel.tick_params(length=0)
    panel.set_title(title, fontsize=10.5)
