# SPDX-License-Identifier: Apache-2.0
"""Figure of an ablation: change without each effect, in tolerances, and its cost."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drill_twin.report.figures.style import GREY, INK, VERMILION, laid_out, styled
from drill_twin.studies.ablation.ablation import Ablation, Change
from drill_twin.studies.ablation.compare import NAMES

NEEDED, NOT_NEEDED = VERMILION, GREY
SMALLEST, LARGEST = 1e-2, 1e2  # tolerances shown


def ablation_figure(ablation: Ablation) -> Figure:
    """Bars of each effect, a panel for each quantity and one for the cost."""
    changes = ablation.changes
    with styled():
        figure = laid_out(
            1.6 + 0.42 * len(changes),
            f"{ablation.scene}: change without each effect (red: beyond tolerance and chance; hatched: too few runs)",
        )
        axes = figure.subplots(1, len(NAMES) + 1, sharey=True)
        rows = np.arange(len(changes))
        for axis, (name, title) in zip(axes, NAMES.items(), strict=False):
            _bars(
                axis, rows, [_shown(change, name) for change in changes],
                [_matters(change, name) for change in changes], [_unknown(change, name) for change in changes],
            )  # fmt: skip
            axis.set_xscale("log")
            axis.set_xlim(SMALLEST, LARGEST)
            axis.axvline(1.0, color=INK, linewidth=0.8)
            axis.set_title(f"change of\n{title}", fontsize=9)
            axis.set_xlabel(f"tolerances\nof {ablation.tolerance:.0%}", fontsize=9)
        none = [False] * len(changes)
        _bars(axes[-1], rows, [100.0 * (change.iteration_share or 0.0) for change in changes], none, none)
        axes[-1].set_title("share of the\nstep time", fontsize=9)
        axes[-1].set_xlabel("% of an\niteration", fontsize=9)
        axes[0].set_yticks(rows, [_label(change) for change in changes])
        axes[0].invert_yaxis()
    return figure


def _bars(axis: Axes, rows: np.ndarray, values: list[float], matters: list[bool], unknown: list[bool]) -> None:
    colours = [NEEDED if needed else NOT_NEEDED for needed in matters]
    hatches = ["///" if hatched else "" for hatched in unknown]
    axis.barh(rows, values, color=colours, height=0.7, hatch=hatches, edgecolor="white", linewidth=0.0)
    axis.grid(visible=False, axis="y")


def _shown(change: Change, name: str) -> float:
    if change.failure:
        return LARGEST
    return float(np.clip(change.quantities[name].tolerances, SMALLEST, LARGEST))


def _matters(change: Change, name: str) -> bool:
    return bool(change.failure) or change.quantities[name].matters


def _unknown(change: Change, name: str) -> bool:
    return not change.failure and not change.quantities[name].matters and not change.quantities[name].known


def _label(change: Change) -> str:
    first, *others = change.left_out
    return f"{first} (with {', '.join(others)})" if others else first
