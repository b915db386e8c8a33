# SPDX-License-Identifier: Apache-2.0
"""Figures of steady whirl: shapes of the states at one command."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from drill_twin.discretisation.discretise import tubes_of
from drill_twin.model.mesh import build_rod
from drill_twin.report.figures.style import BLUE, GREY, VERMILION, blank, head, styled
from drill_twin.rotordynamics.whirl_states import WhirlState
from drill_twin.scene import Scene

MOST_STATES = 5


def states_figure(states: Sequence[WhirlState], scene: Scene) -> Figure:
    """Shapes of the states in the turning frame: along the string, and seen from above with the clearance."""
    shown, command = states[:MOST_STATES], states[0].whirl.command
    arc = build_rod(tubes_of(scene), shown[0].whirl.u.shape[0] - 1).arc
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
            along, above = panels[0, column], panels[1, column]
            along.plot(x, arc, color=BLUE)
            along.plot(y, arc, color=VERMILION, linestyle="--")
            along.set_xlim(-1.15 * clearance, 1.15 * clearance)
            growth = f"growth {state.growth:+.3g} 1/s"
            stable = "stable" if state.is_stable else "unstable"
            speed = f"{state.frequency:+.3f} Hz, ratio {state.ratio:+.3f}"
            along.set_title(f"{state.kind}, {stable}\n{speed}\n{growth}", fontsize=9)
            above.plot(clearance * np.cos(turn), clearance * np.sin(turn), color=GREY, linewidth=0.9)
            above.plot(x, y, color=BLUE)
            above.plot(x[0], y[0], "o", color=VERMILION, markersize=4)
            above.set_aspect("equal")
            above.set_xlabel("x [mm]")
        panels[0, 0].set_ylabel("distance from bit [m]")
        panels[0, 0].legend(["x", "y"], loc="upper left", fontsize=8)
        panels[1, 0].set_ylabel("y [mm]; dot: bit")
    return figure
