# SPDX-License-Identifier: Apache-2.0
"""The cost curve as a picture: error against processor time, both logarithmic."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drill_twin.study.cost.curve import Curve, Measured

COLOURS = {"spatial": "#1f5f8b", "lateral": "#c1652a"}
NAMES = {"spatial": "in space, every unknown", "lateral": "lateral motion only"}
FLOOR = 1e-9  # shown in place of zero


def draw(curve: Curve, path: Path) -> None:
    """Write the figure as PNG."""
    figure = Figure(figsize=(11.0, 4.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    _panel(left, curve, "path", "path before the onset")
    if curve.onset_s is None:
        _panel(right, curve, "radius", "mean orbit radius over the clearance")
    else:
        _panel(right, curve, "onset", f"onset time ({curve.onset_s:.2f} s)")
    left.legend(loc="lower left", fontsize=9)
    figure.suptitle(f"{curve.scene}: what accuracy costs in time", fontsize=13)
    figure.savefig(path, dpi=120)


def _panel(axis: Axes, curve: Curve, quantity: str, title: str) -> None:
    for form, colour in COLOURS.items():
        rungs = [rung for rung in curve.rungs if rung.rung.form == form]
        if rungs:
            axis.loglog(
                [rung.cost for rung in rungs], [_error(rung, quantity) for rung in rungs],
                "o", color=colour, markersize=4, alpha=0.6, label=NAMES[form],
            )  # fmt: skip
    front = curve.front
    axis.loglog(
        [rung.cost for rung in front], [_error(rung, quantity) for rung in front],
        "-", color="black", linewidth=1.0, label="cheapest for its error",
    )  # fmt: skip
    for rung in front:
        axis.annotate(
            f"{rung.rung.elements} el., {rung.rung.step * 1e3:.2g} ms",
            (rung.cost, _error(rung, quantity)), fontsize=7, xytext=(4, 4), textcoords="offset points",
        )  # fmt: skip
    noise = getattr(curve.noise, quantity)
    if noise:
        axis.axhline(noise, color="grey", linewidth=0.8, linestyle="--")
        axis.annotate(
            "spread of replicas", (1.0, noise), xycoords=("axes fraction", "data"), fontsize=7, ha="right", va="bottom"
        )
    axis.set_title(f"error of the {title}", fontsize=11)
    axis.set_xlabel("processor time per simulated second [s]")
    axis.set_ylabel("relative error")
    axis.grid(alpha=0.3, which="both")


def _error(rung: Measured, quantity: str) -> float:
    return max(getattr(rung.errors, quantity) or 0.0, FLOOR)
