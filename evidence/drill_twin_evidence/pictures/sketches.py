# SPDX-License-Identifier: Apache-2.0
"""Sketches: the hole with its frame and signs, and the nodes with the topics between them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch

from drill_twin.report.figures.style import BLUE, GREEN, GREY, INK, LIGHT, SKY, VERMILION

_STYLE: Any = {"font.family": "DejaVu Sans", "font.size": 10, "svg.hashsalt": "drill_twin", "svg.fonttype": "none"}
_ARROW = {"arrowstyle": "-|>", "linewidth": 1.4, "shrinkA": 0, "shrinkB": 0}


def draw_frames(path: Path) -> None:
    """Draw the hole from the side and along its axis: origin, axes, depth, rotation, weight, clearance and mark.

    Args:
        path: File of the picture (.svg).
    """
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(9.6, 5.2))
        FigureCanvasSVG(figure)
        _draw_side(figure.add_axes((0.0, 0.0, 0.5, 1.0)))
        _draw_section(figure.add_axes((0.5, 0.0, 0.5, 1.0)))
        figure.savefig(path, metadata={"Date": None})


def _draw_side(axes: Axes) -> None:
    axes.set(xlim=(-2.6, 2.9), ylim=(-5.9, 1.5))
    axes.axis("off")
    for side in (-0.8, 0.8):
        axes.plot([side, side], [0.0, -5.0], color=GREY, linewidth=2)
    axes.fill_between([-1.4, 1.4], -5.0, -5.4, color=LIGHT)
    depth = np.linspace(0.0, -5.0, 80)
    bend = 0.6 * np.sin(np.pi * depth / 5.0) ** 2
    axes.plot(bend, depth, color=BLUE, linewidth=3)
    axes.plot(bend[48], depth[48], "o", color=VERMILION, markersize=9)
    axes.text(
        0.95, depth[48], "mark: a named place\nwhose motion is published", va="center", color=VERMILION, fontsize=9
    )
    axes.plot([0.0, 0.0], [0.3, -5.2], color=GREY, linewidth=0.8, linestyle=(0, (6, 4)))
    _arrow(axes, (0.0, 0.0), (0.0, 1.2), "z", (0.1, 1.15))
    _arrow(axes, (0.0, 0.0), (1.5, 0.0), "x (to the low side)", (1.55, -0.05))
    axes.text(-0.12, 0.12, "hole", ha="right", fontsize=9, color=INK, fontweight="bold")
    axes.text(-1.9, 0.35, "origin at the\ntop clamp", fontsize=9, color=GREY)
    turn = np.radians(np.linspace(130.0, 385.0, 60))
    axes.plot(0.42 * np.cos(turn), 0.75 + 0.17 * np.sin(turn), color=GREEN, linewidth=1.6)
    ends = [(0.42 * np.cos(angle), 0.75 + 0.17 * np.sin(angle)) for angle in np.radians([405.0, 380.0])]
    axes.annotate("", ends[0], ends[1], arrowprops={**_ARROW, "color": GREEN})
    axes.text(0.55, 0.62, "rotation: positive\nright-handed about +z", fontsize=9, color=GREEN)
    _arrow(axes, (-2.25, 0.0), (-2.25, -5.0), "", (0.0, 0.0), GREY)
    axes.text(-2.33, -2.5, "depth = -z", rotation=90, va="center", ha="right", fontsize=9, color=GREY)
    _arrow(axes, (0.0, -5.75), (0.0, -5.05), "", (0.0, 0.0), VERMILION)
    axes.text(0.2, -5.75, "weight on bit: positive in compression", fontsize=9, color=VERMILION)
    axes.text(-0.95, -4.95, "node 0 = bit", fontsize=9, ha="right", color=INK)
    axes.text(-0.95, -0.3, "node n = top", fontsize=9, ha="right", color=INK)


def _draw_section(axes: Axes) -> None:
    axes.set(xlim=(-1.5, 1.7), ylim=(-1.75, 1.65), aspect="equal")
    axes.axis("off")
    axes.add_patch(Circle((0, 0), 1.0, facecolor="#f7f7f7", edgecolor=GREY, linewidth=2))
    axes.add_patch(Circle((0, 0), 0.7, fill=False, edgecolor=GREY, linewidth=1, linestyle=(0, (5, 4))))
    centre = np.array([0.42, 0.42])
    sweep = np.linspace(-1.8, 0.25 * np.pi - 0.5, 60)
    axes.plot(0.594 * np.cos(sweep), 0.594 * np.sin(sweep), color=BLUE, linewidth=1.5)
    axes.add_patch(Circle(tuple(centre), 0.3, facecolor=SKY, edgecolor=BLUE, linewidth=1.5, alpha=0.6))
    axes.plot(*centre, ".", color=BLUE)
    axes.plot(centre[0] + 0.3 * np.cos(2.2), centre[1] + 0.3 * np.sin(2.2), "o", color=VERMILION, markersize=8)
    axes.plot(0, 0, "+", color=INK, markersize=10)
    _arrow(axes, (0, 0), (1.25, 0), "x", (1.3, -0.05))
    _arrow(axes, (0, 0), (0, 1.25), "y", (0.05, 1.25))
    _arrow(axes, (0, 0), (0.7 * np.cos(3.6), 0.7 * np.sin(3.6)), "", (0, 0), GREY)
    axes.text(-0.62, -0.14, "clearance", fontsize=9, color=GREY, ha="center")
    labels = (
        ("wall of the hole", (-0.95, 1.02), GREY, (-0.74, 0.7)),
        ("the centre line stays inside", (-1.35, -1.22), GREY, (-0.45, -0.55)),
        ("string", (0.95, 0.92), BLUE, (0.66, 0.58)),
        ("mark on the surface (on: wall)", (0.32, 1.42), VERMILION, (0.22, 0.68)),
        ("orbit of the centre line (on: centre)", (0.0, -1.42), BLUE, (0.42, -0.44)),
    )
    for text, place, colour, target in labels:
        axes.annotate(text, target, place, fontsize=9, color=colour,
                      arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.8})  # fmt: skip
    words = "seen from above: forward whirl is counter-clockwise\nwhere the string turns counter-clockwise"
    axes.text(0.0, -1.68, words, ha="center", fontsize=9, color=INK)


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], text: str, place: tuple[float, float],
           colour: str = INK) -> None:  # fmt: skip
    axes.annotate("", end, start, arrowprops={**_ARROW, "color": colour})
    axes.text(*place, text, fontsize=10, color=colour)


NODES = {
    "rig_driver": (0.0, 2.0), "gateway": (0.0, 0.6), "simulator": (2.9, 2.0), "analyzer": (5.9, 2.0),
    "recorder": (4.6, 0.1), "watch": (8.6, 2.0), "advisor": (7.2, 0.6), "estimator": (2.4, 0.1),
}  # fmt: skip
OPTIONAL = ("gateway", "recorder", "watch", "advisor", "estimator")
TOPICS = (
    ("rig_driver", "simulator", "/rig/command", (1.45, 2.12)),
    ("gateway", "simulator", "/rig/command", (1.15, 1.42)),
    ("gateway", "estimator", "/measured/rig/state", (1.1, 0.02)),
    ("simulator", "analyzer", "/marks/state\n/rig/state", (4.4, 2.12)),
    ("analyzer", "watch", "/whirl/state\n/whirl/motion\n/whirl/onset", (7.28, 2.12)),
    ("simulator", "recorder", "all topics", (3.35, 1.05)),
    ("analyzer", "recorder", "findings", (5.55, 1.0)),
    ("analyzer", "advisor", "/whirl/motion", (6.95, 1.32)),
    ("advisor", "watch", "/advice/state", (8.4, 1.2)),
)


def draw_nodes(path: Path) -> None:
    """Draw the nodes, those that run by default in full lines, and the topics between them.

    Args:
        path: File of the picture (.svg).
    """
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(10.4, 3.7))
        FigureCanvasSVG(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set(xlim=(-0.8, 9.5), ylim=(-0.55, 3.1))
        axes.axis("off")
        boxes = {name: _box(axes, name, place) for name, place in NODES.items()}
        for start, end, topic, place in TOPICS:
            ends = {"patchA": boxes[start], "patchB": boxes[end], "color": GREY}
            axes.annotate("", NODES[end], NODES[start], arrowprops={**_ARROW, **ends})
            axes.text(*place, topic, fontsize=9, color=INK, ha="center", va="bottom",
                      bbox={"facecolor": "white", "edgecolor": "none", "pad": 1})  # fmt: skip
        back = {**_ARROW, "color": GREY, "connectionstyle": "arc3,rad=0.25"}
        axes.annotate("", (0.1, 2.3), (2.8, 2.3), arrowprops=back)
        axes.text(1.45, 2.75, "/clock", fontsize=9, color=INK, ha="center")
        axes.text(-0.7, -0.45, "dashed: started on request", fontsize=9, color=GREY)
        figure.savefig(path, metadata={"Date": None})


def _box(axes: Axes, name: str, place: tuple[float, float]) -> FancyBboxPatch:
    x, y = place
    box = FancyBboxPatch((x - 0.6, y - 0.22), 1.2, 0.44, boxstyle="round,pad=0.03", facecolor="#e8f1f8", edgecolor=BLUE)
    box.set_linestyle((0, (4, 3)) if name in OPTIONAL else "-")
    axes.add_patch(box)
    axes.text(x, y, name, ha="center", va="center", fontsize=10, color=INK)
    return box
