# SPDX-License-Identifier: Apache-2.0
"""Orbit and shape of the string in each motion state, from runs of the installed scenes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

import drill_twin as dt
from drill_twin.core.arrays import Array
from drill_twin.report.figures.style import BLUE, GREEN, INK, LIGHT, ORANGE, VERMILION
from drill_twin.report.string_curve import smooth

LATER = 5.0
"""Time that a run goes on behind what is drawn [s]: a state is found from what follows, too."""


@dataclass(frozen=True)
class Panel:
    """A motion state, the run that shows it, and the end of the part that is drawn [s]."""

    title: str
    note: str
    scene: str
    end: float
    revolutions: float = 2.0
    """Length of the orbit that is drawn [rev]."""
    shape: bool = False
    """The whole string is drawn from the side, too."""
    changes: dict[str, str] = field(default_factory=dict)


FAST = {"numerics.frame_rate": "400 Hz"}
PANELS = (
    Panel("rotation about a fixed axis", "the string turns and stays in place", "pa6_bench", 15.0,
          changes={"wob": "5 N"}),
    Panel("forward whirl", "around the hole, with the rotation", "pa6_bench", 8.2),
    Panel("backward whirl", "around the hole, against the rotation", "pa6_bench", 11.7, 1.7,
          changes={"effects.wall_friction.coefficient": "0.6", "effects.internal_damping.bending_time": "3 ms"}),
    Panel("rolling along the wall", "backward on the wall, without slip", "bha_full_size", 14.0),
    Panel("spiral", "the shape is a helix", "pa6_bench", 18.0, shape=True),
    Panel("second bending", "the shape crosses the axis", "pa6_calibrated", 25.0, shape=True,
          changes={"rig.rotation.value": "6 rev/s", **FAST}),
    Panel("irregular", "no steady radius or rate", "pa6_calibrated", 25.0, 3.0, changes={"wob": "300 N", **FAST}),
)  # fmt: skip


def draw(path: Path) -> None:
    """Draw a panel for each motion state, seen along the hole from above; radii over the clearance.

    Args:
        path: File of the picture (.png).
    """
    with mpl.rc_context({"font.family": "DejaVu Sans", "font.size": 9}):
        figure = Figure(figsize=(10.0, 5.8))
        FigureCanvasAgg(figure)
        axes = figure.subplots(2, 4).ravel()
        figure.subplots_adjust(left=0.02, right=0.98, bottom=0.05, top=0.94, wspace=0.12, hspace=0.22)
        for panel, place in zip(PANELS, axes, strict=False):
            _draw_panel(panel, place)
        _draw_key(axes[-1])
        figure.savefig(path, dpi=100)


def _draw_panel(panel: Panel, axes: Axes) -> None:
    result = dt.Simulation(panel.scene, panel.changes).run(duration=panel.end + LATER)
    turns = np.asarray(result.rig.top_drive_angle) / (2.0 * np.pi)
    now = int(np.searchsorted(result.time, panel.end))
    part = slice(int(np.searchsorted(turns, turns[now] - panel.revolutions)), now + 1)
    middle = float(np.mean(result.time[part]))
    (state,) = {row["state"] for row in result.whirl.motion if row["start_s"] <= middle < row["end_s"]}
    if state != panel.title:
        raise RuntimeError(f"{panel.title}: expected at {middle:.1f} s of {panel.scene}, found {state}")
    mark = int(np.argmax(np.abs(result.centre[part]).max(axis=(0, 2))))
    clearance = result.scene.clearance_at(result.scene.string.marks[mark].distance_from_bit)
    orbit = result.centre[part, mark] / clearance
    _draw_wall(axes)
    parts = np.stack([orbit[:-1], orbit[1:]], axis=1)
    axes.add_collection(
        LineCollection(list(parts), colors=BLUE, alpha=np.linspace(0.08, 1.0, len(parts)), linewidths=1.8)
    )
    if panel.shape:
        nodes = result.string
        _draw_shape(axes, smooth(nodes.position[now : now + 1], nodes.tangent[now : now + 1])[0] / clearance)
    axes.plot(*orbit[-1], "o", color=VERMILION, markersize=6)
    axes.set_title(panel.title, fontsize=10, fontweight="bold")
    axes.set_xlabel(panel.note, fontsize=8.5)


def _draw_shape(axes: Axes, line: Array) -> None:
    """Draw the string from the side, top to bottom, x and y."""
    inner = axes.inset_axes((0.30, 0.22, 0.40, 0.56))
    height = np.linspace(0.0, 1.0, len(line))
    inner.plot(line[:, 0], height, color=ORANGE, linewidth=1.6)
    inner.plot(line[:, 1], height, color=GREEN, linewidth=1.6)
    inner.set(xlim=(-1.1, 1.1), ylim=(-0.02, 1.02))
    inner.axis("off")


def _draw_wall(axes: Axes) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    axes.fill(1.06 * np.cos(angle), 1.06 * np.sin(angle), color="#f5f5f5")
    axes.plot(np.cos(angle), np.sin(angle), color=LIGHT, linewidth=1.5)
    axes.plot(0.0, 0.0, "+", color=INK, markersize=6)
    axes.set(xlim=(-1.12, 1.12), ylim=(-1.12, 1.12), aspect="equal", xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(False)


def _draw_key(axes: Axes) -> None:
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0), xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(False)
    rows = (
        ("-", LIGHT, "where the string touches the wall"),
        ("+", INK, "axis of the hole"),
        ("-", BLUE, "orbit of a mark; it fades with age"),
        ("o", VERMILION, "the mark now"),
        ("-", ORANGE, "the string from the side: x"),
        ("-", GREEN, "the string from the side: y"),
    )
    for k, (form, colour, text) in enumerate(rows):
        height = 0.86 - 0.14 * k
        if form == "-":
            axes.plot([0.02, 0.12], [height, height], color=colour, linewidth=2)
        else:
            axes.plot(0.07, height, form, color=colour, markersize=7)
        axes.text(0.16, height, text, va="center", fontsize=8.5)
    axes.set_title("seen from above, along the hole", fontsize=10)
