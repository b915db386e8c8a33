# SPDX-License-Identifier: Apache-2.0
"""Steady whirl states and their branches as plain data, tables and figures."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from drill_twin.core.table import Table
from drill_twin.core.units.system import UnitSystem
from drill_twin.dynamics.discretisation.resolution import mesh, resolution_of
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin.dynamics.rotordynamics.steady.branches import Branch
from drill_twin.dynamics.rotordynamics.steady.whirl_state import WhirlState
from drill_twin.dynamics.rotordynamics.steady.whirl_states import rolling_ratios
from drill_twin.report.figures.style import BLUE, GREY, INK, MARK_COLOURS, VERMILION, laid_out, styled
from drill_twin.scene import Scene

MOST_STATES = 5
"""Largest number of states in a figure, so that each panel can be read."""
PARAMETERS = {"wob": ("weight on bit", "force"), "rpm": ("rotation", "rotation")}
"""Words and quantity of a parameter."""


def shown_parameter(key: str, units: UnitSystem) -> tuple[str, float]:
    """Label of a parameter of branches, and the size of its unit in SI: 1 for a key of the scene."""
    if key not in PARAMETERS:
        return key, 1.0
    words, quantity = PARAMETERS[key]
    return f"{words} [{getattr(units, quantity)}]", 1.0 / float(units.show(1.0, quantity))


def states_figure(states: Sequence[WhirlState], scene: Scene) -> Figure:
    """Shapes of the states in the turning frame: along the string, and seen from above with the clearance."""
    shown, command, units = states[:MOST_STATES], states[0].whirl.command, scene.unit_system
    clearance, turn = units.show(scene.least_clearance, "offset"), np.linspace(0.0, math.tau, 200)
    with styled():
        at = units.set_point(command.weight_on_bit, command.rotation)
        figure = laid_out(6.4, f"{scene.name}: steady whirl at {at}")
        panels = figure.subplots(2, len(shown), squeeze=False, height_ratios=(1.5, 1.0))
        for column, state in enumerate(shown):
            x, y = (units.show(state.whirl.u[:, k], "offset") for k in (0, 1))
            arc = units.show(mesh(scene, state.elements).arc, "length")
            along, above = panels[0, column], panels[1, column]
            along.plot(x, arc, color=BLUE)
            along.plot(y, arc, color=VERMILION, linestyle="--")
            along.set_xlim(-1.15 * clearance, 1.15 * clearance)
            speed = f"{state.frequency:+.3f} Hz, ratio {state.ratio:+.3f}\ngrowth {state.growth:+.3g} 1/s"
            along.set_title(f"{state.kind}, {state.verdict}\n{speed}", fontsize=9)
            above.plot(clearance * np.cos(turn), clearance * np.sin(turn), color=GREY, linewidth=0.9)
            above.plot(x, y, color=BLUE)
            above.plot(x[0], y[0], "o", color=VERMILION, markersize=4)
            above.set(aspect="equal", xlabel=f"x [{units.offset}]")
        panels[0, 0].set_ylabel(f"distance from bit [{units.length}]")
        panels[0, 0].legend(["x", "y"], loc="upper left", fontsize=8)
        panels[1, 0].set_ylabel(f"y [{units.offset}]; dot: bit")
    return figure


def branches_figure(branches: Sequence[Branch], name: str, units: UnitSystem) -> Figure:
    """Whirl frequency and ratio over the parameter: stable drawn through, unstable dashed, folds, Hopf points marked.

    Args:
        branches: In one parameter.
        name: Of the scene.
        units: Of the axis.
    """
    label, unit = shown_parameter(branches[0].parameter, units)
    with styled():
        figure = laid_out(5.0, f"{name}: steady whirl over {label.split(' [')[0]}")
        panels = figure.subplots(1, 2)
        for number, one in enumerate(branches):
            colour = MARK_COLOURS[number % len(MARK_COLOURS)]
            stable = np.array([state.is_stable for state in one.states])
            values = one.values / unit
            for panel, quantity in zip(panels, ("frequency", "ratio"), strict=True):
                seen = np.array([getattr(state, quantity) for state in one.states])
                panel.plot(values, seen, color=colour, linestyle=(0, (2, 2)), linewidth=1.0)
                panel.plot(values, np.where(stable, seen, np.nan), color=colour, linewidth=2.2)
                panel.plot(values[list(one.folds)], seen[list(one.folds)], "s", color=INK, markersize=5, zorder=4)
                panel.plot(values[list(one.hopf)], seen[list(one.hopf)], "D", color=VERMILION, markersize=5, zorder=4)
                for end, reason in zip((0, -1), one.ends, strict=True):
                    if "Newton" in reason:
                        panel.plot(values[end], seen[end], "x", color=INK, markersize=7, zorder=4)
        panels[0].set(xlabel=label, ylabel="whirl frequency [Hz]")
        panels[1].set(xlabel=label, ylabel="whirl over rotation [-]")
        figure.legend(handles=_signs(branches), loc="outside lower left", ncol=7, fontsize=8.5)
    return figure


def _signs(branches: Sequence[Branch]) -> list[Line2D]:
    """Entries of the legend, of what there is."""
    lines = [Line2D([], [], color=BLUE, linewidth=2.2, label="stable")]
    lines.append(Line2D([], [], color=BLUE, linestyle=(0, (2, 2)), label="unstable"))
    points = (
        (any(one.folds for one in branches), INK, "s", "fold"),
        (any(one.hopf for one in branches), VERMILION, "D", "Hopf point"),
        (any("Newton" in reason for one in branches for reason in one.ends), INK, "x", "no convergence"),
    )
    return lines + [
        Line2D([], [], color=colour, marker=marker, linestyle="", markersize=5, label=label)
        for there, colour, marker, label in points
        if there
    ]


def state_data(state: WhirlState, modulated: float | None = None) -> dict[str, Any]:
    """A steady whirl: set-points, frequency [Hz], growth [1/s], contact, shape in the turning frame [m].

    Args:
        state: The state.
        modulated: Size of its modulation by bow and eccentricity [m]; None for a state locked to the rotation.
    """
    command = state.whirl.command
    return {
        "weight_on_bit_n": command.weight_on_bit,
        "rotation_rev_s": command.rotation / math.tau,
        "kind": state.kind,
        "frequency_hz": state.frequency,
        "ratio": state.ratio,
        **state.stability(),
        "slip": state.slip,
        "touching": state.touching,
        "modulation_m": modulated,
        "x_m": state.whirl.u[:, 0].tolist(),
        "y_m": state.whirl.u[:, 1].tolist(),
    }


def branch_data(branch: Branch) -> dict[str, Any]:
    """Frequencies [Hz], ratios, growth [1/s] along a branch, its folds and Hopf points, and why it ends; SI values."""
    return {
        "parameter": branch.parameter,
        "values": branch.values.tolist(),
        "frequency_hz": [state.frequency for state in branch.states],
        "ratio": [state.ratio for state in branch.states],
        "growth_per_s": [state.growth for state in branch.states],
        "stable": [state.is_stable for state in branch.states],
        "kind": [state.kind for state in branch.states],
        "folds": [float(branch.values[k]) for k in branch.folds],
        "hopf": [float(branch.values[k]) for k in branch.hopf],
        "ends": list(branch.ends),
    }


_STABLE = {"stable": "yes", "unstable": "no", "not determined": "?"}


def shown_states(
    own: Scene, found: Sequence[WhirlState], locked: Sequence[WhirlState], shares: Sequence[float | None]
) -> Iterator[Table | str]:
    """Table of the states, modulated by a share of the clearance (None: locked), and what it leaves open."""
    if states := (*found, *locked):
        yield _table(states, shares, own)
    for state in states:
        if state.lost_at:
            where = f"{state.kind} at {state.frequency:+.4f} Hz: not found again on {state.lost_at} elements"
            yield f"{where}, so it may be of the mesh of {state.elements}"
    if not found:
        yield f"{own.name}: {_none_found(own)}"


def _none_found(scene: Scene) -> str:
    """Sentence where the search finds no steady whirl."""
    ratios = rolling_ratios(EquationsOfMotion(scene).model)
    text = "no steady whirl found at these set-points; more first shapes with --starts, or a run in time"
    if len(ratios) == 1:
        return text
    rolling = " and ".join(f"{ratio:.3g}" for ratio in ratios)
    return f"{text}. Its parts roll on the wall at {rolling} of the rotation, so it cannot roll as a whole"


def _table(states: Sequence[WhirlState], modulated: Sequence[float | None], scene: Scene) -> Table:
    command = states[0].whirl.command
    rows = [
        (
            state.kind, f"{state.frequency:+.3f}", f"{state.ratio:+.3f}", _STABLE[state.verdict],
            f"{state.growth:+.3g}", "?" if math.isnan(state.growth_change) else f"{state.growth_change:.1g}",
            f"{state.growth_frequency:.3g}", f"{100.0 * state.touching:.0f}%",
            "" if share is None else f"{100.0 * share:.1g}%",
        )
        for state, share in zip(states, modulated, strict=True)
    ]  # fmt: skip
    finest = sorted({state.elements for state in states})
    title = (
        f"{scene.name}: steady whirl at {scene.unit_system.set_point(command.weight_on_bit, command.rotation)}. "
        "Frequency in Hz, ratio to the rotation; growth of the fastest disturbance in 1/s, +- its larger change on the "
        "last two meshes, each twice as fine as the one before (stable ?: its sign is not determined), its "
        "frequency in the turning frame in Hz; share of the length on the wall; modulation by bow "
        f"and eccentricity to first order, over the clearance. On {' or '.join(map(str, finest))} elements. Locked: "
        "the bent string turns with the rotation."
    )
    columns = ("whirl", "Hz", "ratio", "stable", "growth", "+-", "at", "wall", "mod.")
    return Table(columns, rows, title=title, right=(1, 2, 4, 5, 6, 7, 8))


def shown_branches(scene: Scene, found: Sequence[Branch], key: str) -> Iterator[Table | str]:
    """Table of the branches over a parameter, and the mesh that they are of."""
    label, unit = shown_parameter(key, scene.unit_system)
    rows = [
        (
            str(number + 1), f"{one.values.min() / unit:.4g} to {one.values.max() / unit:.4g}",
            f"{min(s.ratio for s in one.states):+.3f} to {max(s.ratio for s in one.states):+.3f}",
            f"{100.0 * sum(s.is_stable for s in one.states) / len(one.states):.0f} %",
            ", ".join(f"{one.values[k] / unit:.4g}" for k in one.folds) or "none",
            ", ".join(f"{one.values[k] / unit:.4g}" for k in one.hopf) or "none", "; ".join(one.ends),
        )
        for number, one in enumerate(found)
    ]  # fmt: skip
    columns = ("branch", label, "ratio", "points stable", "folds", "Hopf points", "ends (low, high side)")
    yield Table(columns, rows, title=f"{scene.name}: branches of steady whirl")
    yield (
        f"Branches are computed on a mesh of {resolution_of(scene)[0]} elements, the run's; without --over, the "
        "states at one set-point show how far finer meshes move them."
    )
