# SPDX-License-Identifier: Apache-2.0
"""Figures of the reproduction, as in the paper, with the published numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch
from matplotlib.ticker import MaxNLocator

from drill_twin.core.arrays import number_or_nan
from drill_twin.report.figures.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    STATE_COLOURS,
    VERMILION,
    blank,
    head,
    styled,
)
from drill_twin.whirl import MotionState
from drill_twin_evidence.paper.runs import full_size as big
from drill_twin_evidence.paper.runs.cases import LOAD, LOADS, REFERENCE, SPEED, SPEEDS, Case
from drill_twin_evidence.paper.runs.published import CRITICAL_TIME, DISPLACEMENT, FREQUENCY, RATIO, published
from drill_twin_evidence.paper.runs.reproduction import Reproduction
from drill_twin_evidence.paper.runs.run import Run, x_spectrum

MARKS = ("mark_3", "mark_2", "mark_1")
PAPER: Any = {"marker": "D", "color": VERMILION, "linestyle": "none", "markersize": 7, "zorder": 5}
OURS: Any = {"marker": "o", "color": BLUE, "markersize": 5}
LINE: Any = {"marker": "o", "color": GREY, "markersize": 7, "fillstyle": "none", "linestyle": "none"}
"""Highest line of mark_2 along x, as in `spectra`; apart from the whirl where the motion is irregular."""


def displacement(done: Reproduction) -> Figure:
    """The paper's Figs 4 to 6: displacement of marks 3, 2, 1 along x and y, 40 N, 2 rev/s."""
    run = done.runs[REFERENCE]
    largest = {n.mark: n.value for n in published().bench if n.what == DISPLACEMENT}
    onset = next(n.value for n in published().bench if n.what == CRITICAL_TIME and n.weight_on_bit == LOAD)
    figure = blank(7.2)
    head(figure, f"Displacement of the marked points, {REFERENCE} (the paper's Figs 4 to 6)")
    panels = figure.subplots(3, 1, sharex=True, gridspec_kw={"top": 0.9, "bottom": 0.08, "left": 0.09, "right": 0.97})
    for panel, mark in zip(panels, MARKS, strict=True):
        place = run.point[:, run.index(mark), :2] * 1e3
        panel.plot(run.time, place[:, 0], color=BLUE, linewidth=0.7, label="x")
        panel.plot(run.time, place[:, 1], color=ORANGE, linewidth=0.7, label="y")
        for sign in (-1, 1):
            panel.axhline(sign * largest[mark], color=VERMILION, linestyle="--", linewidth=1.0)
        panel.axvline(onset, color=VERMILION, linewidth=1.2, label="published")
        if run.summary.onset_s is not None:
            panel.axvline(run.summary.onset_s, color=INK, linestyle="--", linewidth=1.0, label="our onset")
        panel.set_title(f"{mark}: published largest {largest[mark]:g} mm, ours {np.abs(place).max():.0f} mm")
        panel.set_ylabel("[mm]")
        panel.set_ylim(-100, 100)
    panels[0].legend(loc="upper right", ncols=4, bbox_to_anchor=(1.0, 1.3))
    panels[-1].set_xlabel("time [s]")
    return figure


def paths(done: Reproduction) -> Figure:
    """The paper's Figs 8, 9 and 14: mark-2 across the hole and in space."""
    cases = (REFERENCE, Case(LOAD, 6.0), Case(300.0, SPEED))
    figure = blank(7.4)
    head(figure, "Path of mark-2 across the hole and along it (the paper's Figs 8, 9 and 14)")
    wall = done.scene.hole.radius * 1e3
    for column, case in enumerate(cases):
        run = done.runs[case]
        place = run.point[:, run.index("mark_2")] * 1e3
        flat = figure.add_axes((0.075 + 0.315 * column, 0.47, 0.27, 0.40))
        flat.add_patch(Circle((0, 0), wall, fill=False, edgecolor=INK, linewidth=1.6))
        flat.plot(place[:, 0], place[:, 1], color=BLUE, linewidth=0.35)
        flat.set_xlim(-1.08 * wall, 1.08 * wall)
        flat.set_ylim(-1.08 * wall, 1.08 * wall)
        flat.set_aspect("equal")
        flat.set_title(str(case))
        flat.set_xlabel("x [mm]")
        if column == 0:
            flat.set_ylabel("y [mm]")
        solid: Any = figure.add_axes((0.04 + 0.32 * column, 0.02, 0.29, 0.38), projection="3d")
        solid.plot(place[:, 0], place[:, 1], place[:, 2], color=BLUE, linewidth=0.35)
        solid.tick_params(labelsize=7, pad=-2)
        solid.zaxis.set_major_locator(MaxNLocator(4))
        if column == 0:
            figure.text(0.06, 0.40, "x, y, z [mm]", color=INK)
    return figure


def spectra(done: Reproduction) -> Figure:
    """The paper's Figs 10 and 15: spectra of mark-2 along x over speed and over load."""
    figure = blank(7.6)
    head(figure, "Spectrum of mark-2 along x after the onset (the paper's Figs 10 and 15)")
    sweeps = (([Case(LOAD, speed) for speed in SPEEDS], 8.0), ([Case(load, SPEED) for load in LOADS], 3.0))
    for column, (cases, widest) in enumerate(sweeps):
        panel = figure.add_axes((0.085 + 0.49 * column, 0.08, 0.405, 0.82))
        for number, case in enumerate(cases):
            frequency, height = x_spectrum(done.runs[case], "mark_2")
            if height.size:
                panel.plot(frequency, number + 0.85 * height / height.max(), color=BLUE, linewidth=0.9)
            panel.plot([case.speed] * 2, [number, number + 0.85], color=GREY, linewidth=0.9, linestyle=":")
            for value in _frequencies(case):
                panel.plot([value] * 2, [number, number + 0.85], color=VERMILION, linewidth=1.4)
        panel.set_yticks(
            range(len(cases)), [f"{c.speed:g} rev/s" if column == 0 else f"{c.weight_on_bit:g} N" for c in cases]
        )
        panel.set_xlim(0.0, widest)
        panel.set_xlabel("frequency [Hz]; orange: published, dotted: rotation")
        panel.set_title("40 N" if column == 0 else "2 rev/s")
    return figure


def _frequencies(case: Case) -> list[float]:
    """Published whirl frequencies of a case, from ratios too [Hz]."""
    found = []
    for number in published().bench:
        if (number.weight_on_bit, number.speed) == case:
            if number.what == FREQUENCY:
                found.append(number.value)
            elif number.what == RATIO:
                found.append(number.value * case.speed)
    return found


def over_speed(done: Reproduction) -> Figure:
    """The paper's Figs 11 to 13."""
    figure = _three("Over speed at 40 N (the paper's Figs 11 to 13)")
    _fill(figure, done, [Case(LOAD, speed) for speed in SPEEDS], "rotation [rev/s]", lambda case: case.speed)
    figure.axes[2].axvspan(published().surge.low, published().surge.high, color=VERMILION, alpha=0.12)
    return figure


def over_load(done: Reproduction) -> Figure:
    """The paper's Figs 16 to 18."""
    figure = _three("Over weight on bit at 2 rev/s (the paper's Figs 16 to 18)")
    cases = [Case(load, SPEED) for load in LOADS]
    _fill(figure, done, cases, "weight on bit [N]", lambda case: case.weight_on_bit)
    return figure


def _three(title: str) -> Figure:
    figure = blank(3.9)
    head(figure, title)
    figure.subplots(1, 3, gridspec_kw={"top": 0.76, "bottom": 0.15, "left": 0.065, "right": 0.98, "wspace": 0.25})
    return figure


def _fill(figure: Figure, done: Reproduction, cases: list[Case], label: str, where: Callable[[Case], float]) -> None:
    names = (("onset_s", "critical time [s]", CRITICAL_TIME), ("frequency_hz", "whirl frequency [Hz]", FREQUENCY),
             ("ratio", "whirl over rotation", RATIO))  # fmt: skip
    places = [where(case) for case in cases]
    for panel, (name, title, what) in zip(figure.axes, names, strict=True):
        values = [getattr(done.measured[case], name) for case in cases]
        panel.plot(places, [number_or_nan(value) for value in values], label="ours, of the centre line", **OURS)
        if what != CRITICAL_TIME:
            lines = [_line(done, case) / (case.speed if what == RATIO else 1.0) for case in cases]
            panel.plot(places, lines, label="ours, highest line along x", **LINE)
        for case in cases:
            for number in published().bench:
                if (number.weight_on_bit, number.speed) == case and (
                    value := _as(number.what, what, number.value, case)
                ) is not None:
                    panel.plot([where(case)], [value], **PAPER)
        panel.plot([], [], label="published", **PAPER)
        panel.set_title(title)
        panel.set_xlabel(label)
        panel.margins(y=0.12)
        panel.set_ylim(bottom=min(0.0, panel.get_ylim()[0]))
    handles, labels = figure.axes[1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper right", bbox_to_anchor=(0.985, 0.93), ncols=3)


def _line(done: Reproduction, case: Case) -> float:
    """Highest line of mark_2 along x [Hz]; NaN where there is none."""
    return number_or_nan(done.measured[case].line_hz)


def _as(given: str, wanted: str, value: float, case: Case) -> float | None:
    """A published number as another quantity: ratios convert to frequencies and back."""
    if given == wanted:
        return value
    if (given, wanted) == (FREQUENCY, RATIO):
        return value / case.speed
    return value * case.speed if (given, wanted) == (RATIO, FREQUENCY) else None


def motion(done: Reproduction) -> Figure:
    """Motion states of every run over time, for comparison with the paper's Fig. 7."""
    cases = [Case(LOAD, speed) for speed in SPEEDS] + [Case(load, SPEED) for load in LOADS if load != LOAD]
    figure = blank(5.6)
    head(figure, "Motion of the string in every run (the paper's Fig. 7)")
    panel = figure.add_axes((0.13, 0.19, 0.845, 0.72))
    states = {state.value: state for state in MotionState}
    seen = set()
    for number, case in enumerate(cases):
        periods, end = done.measured[case].motion, float(done.runs[case].time[-1])
        for (start, name), stop in zip(periods, [*(s for s, _ in periods[1:]), end], strict=True):
            panel.barh(-number, stop - start, left=start, height=0.8, color=STATE_COLOURS[states[name]])
            seen.add(states[name])
    panel.set_yticks([-number for number in range(len(cases))], [str(case) for case in cases])
    panel.set_xlabel("time [s]")
    panel.grid(visible=False)
    legend = [Patch(color=STATE_COLOURS[state], label=state.value) for state in MotionState if state in seen]
    figure.legend(handles=legend, loc="lower center", ncols=4)
    return figure


def full_size(done: Reproduction) -> Figure:
    """The paper's Figs 19 to 22: the full-size assembly."""
    figure = blank(11.0)
    head(figure, "The full-size assembly, a stand-in (the paper's Figs 19 to 22)")
    run = done.full_size_runs[big.REFERENCE]
    ranges = {row.number.what: row.number for row in done.full_size}
    for row, (mark, word) in enumerate(((big.NEAR_BIT, "near-bit"), (big.FAR_BIT, "far-bit"))):
        panel = figure.add_axes((0.08, 0.81 - 0.18 * row, 0.9, 0.125))
        speed = run.velocity[:, run.index(mark), 0]
        panel.plot(run.time, speed, color=(BLUE, GREEN)[row], linewidth=0.7)
        for name, style in (("before whirl", ":"), ("in whirl", "--")):
            for value in (ranges[f"{word} velocity {name}"].low, ranges[f"{word} velocity {name}"].high):
                panel.axhline(value, color=VERMILION, linestyle=style, linewidth=1.0)
        panel.set_title(f"{word} velocity along x, 160 kN, 50 r/min; published before whirl dotted, in whirl dashed")
        panel.set_xlim(0.0, run.time[-1])
        panel.set_ylabel("[m/s]")
    panel.set_xlabel("time [s]")
    for column, case in enumerate(big.LOADS):
        _orbit(
            figure,
            (0.06 + 0.32 * column, 0.30, 0.27, 0.24),
            done.full_size_runs[case],
            f"{case.weight_on_bit * 1e-3:g} kN, 50 r/min",
            0.0,
        )
    for column, case in enumerate(big.SPEEDS):
        entropy = done.disorder[column].entropy
        _orbit(figure, (0.05 + 0.245 * column, 0.03, 0.2, 0.2), done.full_size_runs[case],
               f"180 kN, {case.speed * 60:g} r/min\nentropy {entropy:.2f}", 4.0)  # fmt: skip
    return figure


def _orbit(figure: Figure, where: tuple[float, float, float, float], run: Run, title: str, since: float) -> Axes:
    panel = figure.add_axes(where)
    place = run.centre[run.time >= since, run.index("near_bit"), :2] * 1e3
    panel.plot(place[:, 0], place[:, 1], color=BLUE, linewidth=0.5)
    panel.set_aspect("equal")
    panel.set_title(title, fontsize=10)
    panel.set_xlabel("x [mm]", fontsize=8, labelpad=1)
    panel.set_ylabel("y [mm]", fontsize=8, labelpad=0)
    panel.tick_params(labelsize=8)
    return panel


FIGURES: dict[str, Callable[[Reproduction], Figure]] = {
    "paper_displacement": displacement, "paper_paths": paths, "paper_spectra": spectra, "paper_speed": over_speed,
    "paper_load": over_load, "paper_motion": motion, "paper_full_size": full_size,
}  # fmt: skip
"""Figures by the name of their file."""


def draw(done: Reproduction) -> dict[str, Figure]:
    """All figures whose runs are available, by the name of their file."""
    with styled():
        return {
            name: figure(done) for name, figure in FIGURES.items() if name != "paper_full_size" or done.full_size_runs
        }
