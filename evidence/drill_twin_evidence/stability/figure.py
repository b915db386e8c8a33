# SPDX-License-Identifier: Apache-2.0
"""Stability map: energy error as colour, Newton iterations as numbers, limit of an explicit scheme."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm

from drill_twin.report.figures.style import INK, VERMILION, laid_out, save, styled
from drill_twin_evidence.stability.measure import Cell

LABELS = {"wall": "stiffness of the wall [N/m²]", "damping_time": "retardation time of bending [s]"}
LEAST, MOST = 1e-4, 1.0  # range of the energy error


def draw(maps: dict[str, Sequence[Sequence[Cell]]], path: str | Path) -> None:
    """Write the figure as PNG.

    Args:
        maps: Rows of cells (`stability_map`) for `wall`, `damping_time` or both.
        path: File to write.
    """
    with styled():
        figure = laid_out(5.4, "Newton iterations per step of the midpoint rule; x: some steps halved, red: stopped")
        axes = figure.subplots(1, len(maps), squeeze=False)[0]
        images = []
        for axis, (what, rows) in zip(axes, maps.items(), strict=True):
            images.append(_panel(axis, rows))
            axis.set_ylabel(LABELS[what])
            axis.set_xlabel("time step [s]")
        figure.colorbar(images[0], ax=list(axes), label="energy error, of the energy in motion")
        save(figure, Path(path))


def _panel(axis: Any, rows: Sequence[Sequence[Cell]]) -> Any:
    steps = np.array([cell.step for cell in rows[0]])
    shares = np.array([[max(cell.energy, LEAST) if cell.followed else np.nan for cell in row] for row in rows])
    colours = axis.pcolormesh(
        _edges(len(steps)), _edges(len(rows)), shares, cmap="viridis_r", norm=LogNorm(LEAST, MOST), edgecolor="white",
    )  # fmt: skip
    for i, row in enumerate(rows):
        for j, cell in enumerate(row):
            text = f"{cell.iterations:.1f}{' x' if cell.cut > 0.0 else ''}" if cell.followed else "stopped"
            dark = cell.followed and cell.energy > 0.03
            colour = "white" if dark else (INK if cell.followed else VERMILION)
            axis.text(j, i, text, ha="center", va="center", fontsize=7, color=colour)
    limits = [np.interp(np.log10(row[0].limit), np.log10(steps), np.arange(len(steps)), left=-0.5) for row in rows]
    places, heights = np.repeat(limits, 2), np.repeat(np.arange(len(rows)), 2) + np.tile([-0.5, 0.5], len(rows))
    axis.plot(places, heights, color=VERMILION, linewidth=2.5, clip_on=False)
    axis.set_title("orange: an explicit scheme is stable to the left of it only", fontsize=10, loc="left")
    axis.set_xticks(np.arange(len(steps)), [_short(step) for step in steps])
    axis.set_yticks(np.arange(len(rows)), [_short(row[0].value) for row in rows])
    axis.grid(visible=False)
    return colours


def _short(value: float) -> str:
    digits, power = f"{value:.0e}".split("e")
    return f"{digits}e{int(power)}"


def _edges(count: int) -> np.ndarray:
    return np.arange(count + 1) - 0.5
