# SPDX-License-Identifier: Apache-2.0
"""Figures of steady whirl: shapes of the states at one command, and branches over a parameter."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from drill_twin.dynamics.discretisation.refinement import mesh
from drill_twin.dynamics.rotordynamics.steady.branches import Branch
from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState
from drill_twin.report.figures.style import BLUE, GREY, INK, MARK_COLOURS, VERMILION, blank, head, styled
from drill_twin.scene import Scene

MOST_STATES = 5
LABELS = {"load": ("weight on bit [N]", 1.0), "speed": ("rotation [rev/s]", math.tau)}
"""Label of a parameter, and its unit in SI."""


def states_figure(states: Sequence[WhirlState], scene: Scene) -> Figure:
    """Shapes of the states in the turning frame: along the string, and seen from above with the clearance."""
    shown, command = states[:MOST_STATES], states[0].whirl.command
    clearance = 1e3 * scene.least_clearance
    turn = np.linspace(0.0, math.tau, 200)
    with styled():
        figure = blank(6.4)
        at = f"{command.weight_on_bit:g} N, {command.rotation / math.tau:g} rev/s"
        head(figure, f"{scene.name}: steady whirl at {at}")
        panels = figure.subplots(2, len(shown), squeeze=False, height_ratios=(1.5, 1.0))
        figure.subplots_adjust(left=0.08, right=0.98, top=0.8, bottom=0.09, wspace=0.3, hspace=0.3)
        for column, state in enumerate(shown):
            x, y = 1e3 * state.whirl.u[:, 0], 1e3 * state.whirl.u[:, 1]
            arc = mesh(scene, state.elements).arc
            along, above = panels[0, column], panels[1, column]
            along.plot(x, arc, color=BLUE)
            along.plot(y, arc, color=VERMILION, linestyle="--")
            along.set_xlim(-1.15 * clearance, 1.15 * clearance)
            growth = f"growth {state.growth:+.3g} 1/s"
            speed = f"{state.frequency:+.3f} Hz, ratio {state.ratio:+.3f}"
            along.set_title(f"{state.kind}, {state.verdict}\n{speed}\n{growth}", fontsize=9)
            above.plot(clearance * np.cos(turn), clearance * np.sin(turn), color=GREY, linewidth=0.9)
            above.plot(x, y, color=BLUE)
            above.plot(x[0], y[0], "o", color=VERMILION, markersize=4)
            above.set_aspect("equal")
            above.set_xlabel("x [mm]")
        panels[0, 0].set_ylabel("distance from bit [m]")
        panels[0, 0].legend(["x", "y"], loc="upper left", fontsize=8)
        panels[1, 0].set_ylabel("y [mm]; dot: bit")
    return figure


def branches_figure(
    branches: Sequence[Branch], name: str, simulated: Sequence[tuple[float, float, float, bool]] = ()
) -> Figure:
    """Whirl frequency and ratio over the parameter: stable drawn through, unstable dashed, folds, Hopf points marked.

    Args:
        branches: In one parameter.
        name: Of the scene.
        simulated: Values of the parameter with frequency [Hz] and ratio of the simulation in time, and whether that is
            steady: full dots, else open ones.
    """
    parameter = branches[0].parameter
    label, unit = LABELS.get(parameter, (parameter, 1.0))
    with styled():
        figure = blank(5.0)
        head(figure, f"{name}: steady whirl over {label.split(' [')[0]}")
        panels = figure.subplots(1, 2)
        figure.subplots_adjust(left=0.075, right=0.97, top=0.8, bottom=0.12, wspace=0.24)
        for number, one in enumerate(branches):
            colour = MARK_COLOURS[number % len(MARK_COLOURS)]
            stable = np.array([state.is_stable for state in one.states])
            values = one.values / unit
            for panel, of in zip(panels, ("frequency", "ratio"), strict=True):
                seen = np.array([getattr(state, of) for state in one.states])
                panel.plot(values, seen, color=colour, linestyle=(0, (2, 2)), linewidth=1.0)
                panel.plot(values, np.where(stable, seen, np.nan), color=colour, linewidth=2.2)
                panel.plot(values[list(one.folds)], seen[list(one.folds)], "s", color=INK, markersize=5, zorder=4)
                panel.plot(values[list(one.hopf)], seen[list(one.hopf)], "D", color=VERMILION, markersize=5, zorder=4)
                for end, reason in zip((0, -1), one.ends, strict=True):
                    if "Newton" in reason:
                        panel.plot(values[end], seen[end], "x", color=INK, markersize=7, zorder=4)
        for column, panel in enumerate(panels):
            if simulated:
                points = np.array(simulated)
                for steady, fill in ((True, GREY), (False, "white")):
                    own = points[points[:, 3] == steady]
                    panel.plot(own[:, 0] / unit, own[:, 1 + column], "o", color=GREY, mfc=fill, markersize=5, zorder=5)
            panel.set_xlabel(label)
        panels[0].set_ylabel("whirl frequency [Hz]")
        panels[1].set_ylabel("whirl over rotation [-]")
        signs = _signs(branches, simulated=bool(simulated))
        figure.legend(handles=signs, loc="upper left", bbox_to_anchor=(0.06, 0.925), ncol=7, fontsize=8.5)
    return figure


def _signs(branches: Sequence[Branch], *, simulated: bool) -> list[Line2D]:
    """Entries of the legend, of what there is."""
    signs = [Line2D([], [], color=BLUE, linewidth=2.2, label="stable")]
    signs.append(Line2D([], [], color=BLUE, linestyle=(0, (2, 2)), label="unstable"))
    if any(one.folds for one in branches):
        signs.append(Line2D([], [], color=INK, marker="s", linestyle="", markersize=5, label="fold"))
    if any(one.hopf for one in branches):
        signs.append(Line2D([], [], color=VERMILION, marker="D", linestyle="", markersize=5, label="Hopf point"))
    if any("Newton" in reason for one in branches for reason in one.ends):
        signs.append(Line2D([], [], color=INK, marker="x", linestyle="", label="no convergence"))
    dots = [
        Line2D([], [], color=GREY, mfc=fill, marker="o", linestyle="", markersize=5, label=label)
        for fill, label in ((GREY, "simulated, steady"), ("white", "simulated, not steady"))
    ]
    return signs + (dots if simulated else [])
