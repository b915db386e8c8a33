# SPDX-License-Identifier: Apache-2.0
"""Figures: change without each effect of an ablation, and error against processor time."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from drill_twin.core.arrays import Array
from drill_twin.report.figures.style import BLUE, GREY, INK, PURPLE, VERMILION, laid_out, styled
from drill_twin.studies.accuracy.ablation import Ablation, Change
from drill_twin.studies.accuracy.convergence import Curve, MeasuredRun, pareto_front
from drill_twin.studies.accuracy.errors import NAMES

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
                [bool(change.failure) or change.quantities[name].matters for change in changes],
                [not (change.failure or (one := change.quantities[name]).matters or one.known) for change in changes],
            )  # fmt: skip
            axis.set(xscale="log", xlim=(SMALLEST, LARGEST))
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
    hatches = ["///" * hatched for hatched in unknown]
    axis.barh(rows, values, color=colours, height=0.7, hatch=hatches, edgecolor="white", linewidth=0.0)
    axis.grid(visible=False, axis="y")


def _shown(change: Change, name: str) -> float:
    return LARGEST if change.failure else float(np.clip(change.quantities[name].tolerances, SMALLEST, LARGEST))


def _label(change: Change) -> str:
    first, *others = change.left_out
    return f"{first} (with {', '.join(others)})" if others else first


COLOURS = {"spatial": BLUE, "lateral": VERMILION, "joined": PURPLE}
FORMULATION_NAMES = {
    "spatial": "spatial formulation", "lateral": "lateral formulation", "joined": "lateral motion from a depth down",
}  # fmt: skip
PLAIN = FuncFormatter(lambda value, _: f"{value:g}")
LABEL_RATIO = 0.6  # a point is labelled if its error is below this share of the last labelled one
FLOOR = 1e-9  # drawn in place of zero


def cost_figure(curve: Curve) -> Figure:
    """Error over processor time: of the path, and of the onset or, without one, of the radius."""
    with styled():
        figure = laid_out(5.0, f"{curve.scene}: what accuracy costs in time")
        left, right = figure.subplots(1, 2)
        _panel(left, curve, "path", "path before the onset")
        if curve.onset_s is None:
            _panel(right, curve, "radius", "mean orbit radius over the clearance")
        else:
            _panel(right, curve, "onset", f"onset time ({curve.onset_s:.2f} s)")
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _panel(axis: Axes, curve: Curve, quantity: str, title: str) -> None:
    runs = [run for run in curve.runs if run.resolution.tolerance is None]
    for form, colour in COLOURS.items():
        if chosen := [run for run in runs if run.resolution.form == form]:
            axis.loglog(
                [1e3 * run.cost for run in chosen], [_error(run, quantity) for run in chosen],
                "o", color=colour, markersize=4, alpha=0.6, label=FORMULATION_NAMES[form],
            )  # fmt: skip
    front = pareto_front(runs, lambda run: _error(run, quantity))
    axis.loglog(
        [1e3 * run.cost for run in front], [_error(run, quantity) for run in front],
        "-", color=INK, linewidth=1.0, label="cheapest for its error",
    )  # fmt: skip
    last = np.inf
    for run in front:
        if _error(run, quantity) < LABEL_RATIO * last:
            last = _error(run, quantity)
            axis.annotate(  # on the left: above and to the right of the curve are the other runs
                f"{run.resolution.elements} el., {run.resolution.step * 1e3:.2g} ms", (1e3 * run.cost, last),
                fontsize=7, xytext=(-5, -1), textcoords="offset points", ha="right", va="top",
            )  # fmt: skip
    if noise := getattr(curve.noise, quantity):
        axis.axhline(noise, color=GREY, linewidth=0.8, linestyle="--")
        axis.annotate(
            "spread of runs with a random push",
            (1.0, noise),
            xycoords=("axes fraction", "data"),
            fontsize=7,
            ha="right",
            va="bottom",
        )
    axis.set_title(f"error of the {title}", fontsize=11)
    axis.set_xlabel("processor time per simulated second [ms]")
    ms = [1e3 * run.cost for run in runs]
    axis.set_xlim(0.4 * min(ms), 2.0 * max(ms))  # room for the labels
    both: Any = (_inverse, _inverse)
    faster = axis.secondary_xaxis("top", functions=both)
    faster.set_xlabel("× real time", fontsize=8)
    for scale in (axis.xaxis, faster.xaxis):
        scale.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        scale.set_major_formatter(PLAIN)
        scale.set_minor_formatter(NullFormatter())
    axis.set_ylabel("relative error")


def _inverse(cost: Array) -> Array:
    """Milliseconds per second as a multiple of real time, and back."""
    found: Array = 1e3 / np.maximum(cost, FLOOR)
    return found


def _error(run: MeasuredRun, quantity: str) -> float:
    return max(getattr(run.errors, quantity) or 0.0, FLOOR)
