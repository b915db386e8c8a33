# SPDX-License-Identifier: Apache-2.0
"""Tables and figures: change without each effect of an ablation, and error against processor time."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from drill_twin.core.arrays import Array
from drill_twin.core.table import Table
from drill_twin.report.figures.style import BLUE, GREY, INK, PURPLE, VERMILION, laid_out, styled
from drill_twin.studies.accuracy.ablation import Ablation, Change
from drill_twin.studies.accuracy.convergence import Curve, MeasuredRun, pareto_front
from drill_twin.studies.accuracy.errors import NAMES, AblationQuantity, MotionErrors

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
    return np.asarray(1e3 / np.maximum(cost, FLOOR))


def _error(run: MeasuredRun, quantity: str) -> float:
    return max(getattr(run.errors, quantity) or 0.0, FLOOR)


def _share(value: float | None) -> str:
    return "" if value is None else f"{value:.0e}".replace("e-0", "e-")


def tolerance_table(curve: Curve) -> Table:
    """Errors and time by tolerance of Newton's method."""
    tried = [one for one in curve.runs if one.resolution.tolerance is not None]
    rows = [
        (_share(one.resolution.tolerance), _share(one.errors.path), _share(one.errors.onset), f"{one.cost * 1e3:.3g}")
        for one in sorted(tried, key=lambda one: -(one.resolution.tolerance or 0.0))
    ]
    at = f" at {tried[0].resolution.elements} elements, {tried[0].resolution.step * 1e3:.3g} ms" if tried else ""
    return Table(("tolerance", "path", "onset", "ms/s"), rows, title=f"Tolerance{at}", right=range(4))


def cost_table(curve: Curve) -> Table:
    """Runs on the Pareto front, and the spread of repeats."""

    def errors(of: MotionErrors) -> Iterator[str]:
        return (_share(getattr(of, name)) for name in ("path", "onset", "frequency", "radius", "contact"))

    rows = [
        (one.resolution.form, str(one.resolution.elements), f"{one.resolution.step * 1e3:.2g}", *errors(one.errors),
         f"{one.cost * 1e3:.3g}", f"{one.realtime_factor:.0f}", f"{one.frame_p95 * 1e6:.0f}")
        for one in curve.front
    ]  # fmt: skip
    rows.append(("spread", "", "", *errors(curve.noise), "", "", ""))
    columns = ("form", "el.", "step", "path", "onset", "whirl", "orbit", "wall", "ms/s", "× rt", "p95")
    compiling = max(one.compile_seconds for one in curve.runs)
    title = (
        f"{curve.scene}: the cheapest resolution for each error, against {curve.reference.elements} elements and "
        f"{curve.reference.step * 1e3:.3g} ms in the {curve.reference.form} form.\n"
        "Step in ms. Errors: path and time of the onset; after it whirl frequency, mean radius of the orbit and share "
        "at the wall. "
        "Time: processor ms per simulated second, speed over real time (× rt), us that 95 % of the frames stay below; "
        f"compiling or loading took {compiling:.0f} s, once. Spread: of runs set apart by a push of 0.1 mm/s."
    )
    return Table(columns, rows, title=title, right=range(1, 11))


def mesh_table(curve: Curve) -> Table:
    """Errors and time over the number of elements."""

    def row(elements: str, errors: MotionErrors, *price: str) -> tuple[str, ...]:
        found = (
            errors.path, errors.onset, errors.hookload, errors.torque, errors.stick_slip, errors.frequency,
        )  # fmt: skip
        return elements, *map(_share, found), *price

    whole = curve.whole
    step = (whole or curve.runs[0]).resolution.step
    rows = [
        row(f"{one.resolution.elements}{' whole' if one is whole else ''}", one.errors, f"{one.cost * 1e3:.3g}",
            f"{one.realtime_factor:.3g}")
        for one in sorted(curve.runs, key=lambda one: (one is whole, one.resolution.elements))
        if one.resolution.step == step and one.resolution.tolerance is None
    ]  # fmt: skip
    rows.append(row("spread", curve.noise, "", ""))
    title = (
        f"{curve.scene}: errors over elements at a step of {step * 1e3:.2g} ms, against "
        f"{curve.reference.elements} elements and {curve.reference.step * 1e3:.2g} ms"
        f"{' with the joint; whole: `lateral_from=0 m`, what the joint changes (path: marks above it)' * bool(whole)}"
        ".\n"
        "Path and time of the onset; means of hookload and torque over the second half; period of stick-slip; whirl "
        "frequency. Time: processor ms per simulated second, speed over real time (× rt). "
        "Spread: of runs set apart by a push of 0.1 mm/s."
    )
    columns = ("el.", "path", "onset", "hookload", "torque", "stick-slip", "whirl", "ms/s", "× rt")
    return Table(columns, rows, title=title, right=range(9))


def runs_table(curve: Curve) -> Table:
    """All runs with the numbers of each."""
    names = ("path", "onset", "frequency", "radius", "contact", "hookload", "torque", "stick_slip")
    columns = (
        "form", "elements", "step_s", "tolerance", *(f"error_{name}" for name in names), "cost_s_per_s",
        "realtime_factor", "frame_p95_s", "compile_s", "iterations_per_s", "on_front",
    )  # fmt: skip
    rows = (
        (
            one.resolution.form, one.resolution.elements, one.resolution.step, one.resolution.tolerance,
            *(getattr(one.errors, name) for name in names), one.cost,
            one.realtime_factor, one.frame_p95, one.compile_seconds, one.iterations, int(one.on_front),
        )
        for one in curve.runs
    )  # fmt: skip
    return Table(columns, rows)


def effects_table(ablation: Ablation) -> Table:
    """Results and cost without each effect."""
    known = next(change.quantities for change in (*ablation.changes, ablation.reduced) if change.quantities)
    runs = ablation.replicas
    first = ("nothing", "", "", *(_value(key, known[key].before, known[key].runs_before, runs) for key in NAMES))
    title = f"{ablation.scene}, {runs} runs each; * = beyond the tolerance and beyond chance, ? = too few runs to tell"
    columns = ("left out", "step time", "run time", *NAMES.values())
    rows = [first, *(_row(change, runs) for change in ablation.changes)]
    return Table(columns, rows, title=title, right=range(1, len(columns)))


def _row(change: Change, runs: int) -> tuple[str, ...]:
    name = " + ".join(change.left_out)
    if change.failure:
        return (name, "", "", *("no run *" for _ in NAMES))
    prices = (f"{-(share or 0.0):+.0%}" for share in (change.iteration_share, change.cost_share))
    return (name, *prices, *(_cell(key, change.quantities[key], runs) for key in NAMES))


def _cell(key: str, quantity: AblationQuantity, runs: int) -> str:
    mark = " *" if quantity.matters else "  " if quantity.known else " ?"
    return _value(key, quantity.after, quantity.runs_after, runs) + mark


def _value(key: str, value: float | None, having: int, runs: int) -> str:
    unit = {"onset_s": " s", "whirl_frequency_hz": " Hz"}.get(key, "")
    return "none" if value is None else f"{value:.3g}{unit}" + (f" ({having} of {runs})" if having < runs else "")


def effects_verdict(ablation: Ablation) -> str:
    """Sentences on the effects that the scene needs."""
    not_needed = [key for key in ablation.effects if key not in ablation.kept]
    share = ablation.reduced.cost_share or 0.0
    saved = f", which saves {share:.0%} of the run time" if not_needed else ""
    failures = "".join(
        f"There is no run without {' + '.join(change.left_out)}: {change.failure}.\n"
        for change in ablation.changes
        if change.failure
    )
    untold = [
        change.left_out[0] for change in ablation.changes if change.unknown and change.left_out[0] in ablation.kept
    ]
    unknown = f"Kept because {ablation.replicas} runs do not tell: {', '.join(untold)}.\n" if untold else ""
    return (
        f"{failures}At a tolerance of {ablation.tolerance:.1%} this scene calls for: {', '.join(ablation.kept)}.\n"
        f"{unknown}No change is seen without: {', '.join(not_needed) or 'none'}{saved}."
    )
