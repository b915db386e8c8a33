# SPDX-License-Identifier: Apache-2.0
"""Broomstick plot: hookload and torque over the depth of the bit by friction, with measured points on it."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from drill_twin.core.arrays import Array, number_or_none
from drill_twin.core.errors import ArgumentError, TableError
from drill_twin.core.numerals import number
from drill_twin.core.table import Table
from drill_twin.core.units.dimension import FORCE, LENGTH, TORQUE
from drill_twin.core.units.parse import name_and_unit
from drill_twin.core.units.ranges import parse_range
from drill_twin.dynamics.torque_drag.over_depth import LARGEST, LEAST_LOAD, FrictionFit, OverDepth
from drill_twin.report.figures.style import BLUE, GREEN, INK, VERMILION, blank, styled
from drill_twin.scene.records import read_columns

COLUMNS = {
    "trip out": ("trip out", "pick-up", "pickup", "pu", "puw"),
    "trip in": ("trip in", "slack-off", "slackoff", "so", "sow"),
    "off bottom": ("off bottom", "rotating", "rot", "row"),
    "torque": ("torque", "torque off bottom", "tqa", "tq", "trq"),
}
"""Names of columns of measured loads."""
DEPTHS = ("depth", "bit depth", "md", "dept", "dbtm")
"""Names of the column of the depth of the bit."""
MOST = 20
"""Most coefficients."""
PARTS = {"cased": "cased", "open": "open hole", "both": "cased and open hole"}
"""Names of the factors of a fit."""
ON_BOTTOM = 5e3
"""Weight on bit from which a row counts as drilling on bottom [N]: the zero of a rig's weight is no better known."""


class Points(NamedTuple):
    """Measured loads of an operation, or torques off bottom; shape (p,)."""

    depth: Array
    """[m]."""
    value: Array
    """[N] or [N m]."""
    on_bottom: int = 0
    """Number of rows left out, as the curves are of a bit off bottom and these rows have a weight on the bit."""
    left_out: str = ""
    """Values of depth and load that are no measurement: how many, of what and where; empty for none."""


def coefficients(text: str) -> list[float]:
    """Coefficients of friction of a range such as `0.15..0.35:5`, or of a list such as `0.2,0.3`.

    Raises:
        ArgumentError: The text is no range and no list.
    """
    words = [number(word.strip()) for word in text.split(",")]
    found = parse_range("--friction", text).points(5) if ".." in text else [one for one in words if one is not None]
    if not (len(words) <= len(found) <= MOST and all(0.0 <= value <= LARGEST for value in found)):
        raise ArgumentError(
            f'--friction: expected at most {MOST} coefficients from 0 to {LARGEST:g} such as "0.15..0.35:5" or '
            f'"0.2,0.3", found "{text}"'
        )
    return sorted(found)


def read_measured(path: Path) -> dict[str, Points]:
    """Measured points of a record over depth, by operation and `torque`, off bottom where it has the weight on bit.

    Raises:
        TableError: It cannot be read, has no depth or none of the loads, a column without a unit, or no load above 0.
    """
    columns = read_columns(path)
    bare = {name_and_unit(name)[0].lower(): name for name in columns}
    named = {load: next((bare[name] for name in names if name in bare), "") for load, names in COLUMNS.items()}
    depth = next((bare[name] for name in DEPTHS if name in bare), "")
    if not depth or not any(named.values()):
        known = "; ".join(f"{load}: {', '.join(names)}" for load, names in {"depth": DEPTHS, **COLUMNS}.items())
        raise TableError(
            f"{path}: expected a column of depth and a column of a load, found {columns.listed}; known names: {known}"
        )
    places = columns.si(depth, columns.unit(depth, LENGTH), LENGTH, "depth")
    found, drilling = {}, np.zeros(places.size, bool)
    for _ in columns.named("weight_on_bit")[:1]:
        drilling |= columns.channel("weight_on_bit").values > ON_BOTTOM
    for load, name in named.items():
        if name:
            channel, dimension = ("torque", TORQUE) if load == "torque" else ("hookload", FORCE)
            values = columns.si(name, columns.unit(name, dimension), dimension, channel)
            known_rows = np.isfinite(values) & np.isfinite(places)
            kept = known_rows & ~drilling
            if load != "torque" and (low := np.flatnonzero(kept & (np.nan_to_num(values) < LEAST_LOAD))).size:
                raise TableError(f"{path}: expected a load above 0 in {name!r}, found {values[low[0]]:g} N in row "
                                 f"{low[0] + 1}; empty it, or mend the record")  # fmt: skip
            told = "; ".join(
                f"{one} {', '.join(columns.left_out[one])}" for one in (depth, name) if columns.left_out[one]
            )
            found[load] = Points(places[kept], values[kept], int((known_rows & drilling).sum()), told)
    return found


def fits_of(found: OverDepth, points: Mapping[str, Points]) -> dict[str, FrictionFit]:
    """Fits of the factors of friction by load; off bottom has no axial friction.

    Raises:
        ArgumentError: A point lies below the string.
    """
    units, fits = found.scene.unit_system, dict[str, FrictionFit]()
    for load, one in points.items():
        if (deepest := one.depth.max(initial=0.0)) > found.scene.length * (1.0 + 1e-6):
            raise ArgumentError(
                f"--measured: expected depths of the bit up to {units.text(found.scene.length, 'length')}, found "
                f"{units.text(deepest, 'length')} ({load}); take a scene whose string is as long, or fewer rows"
            )
        if load != "off bottom" and one.value.size:
            fits[load] = found.fit(load, one.depth, one.value)
    return fits


def over_depth_data(found: OverDepth, points: Mapping[str, Points], fits: Mapping[str, FrictionFit]) -> dict[str, Any]:
    """Numbers of the plot, SI."""
    return {
        "scene": found.scene.name, "depth_m": found.depth.tolist(), "friction": found.friction.tolist(),
        "cased": [[part.top, part.bottom] for part in found.casing],
        "hookload_n": {one.name: [[number_or_none(load) for load in row] for row in rows.tolist()]
                       for one, rows in zip(found.operations, found.hookload, strict=True)},
        "torque_off_bottom_nm": found.torque.tolist(),
        "measured": {
            load: {"depth_m": one.depth.tolist(), "value": one.value.tolist(), "rows_on_bottom": one.on_bottom,
                   "left_out": one.left_out, **(_fit_data(fits[load]) if load in fits else {})}
            for load, one in points.items()
        },
    }  # fmt: skip


def _fit_data(fit: FrictionFit) -> dict[str, Any]:
    return {
        "friction": dict(zip(fit.parts, fit.friction.tolist(), strict=True)),
        "error": {part: error if math.isfinite(error) else None
                  for part, error in zip(fit.parts, fit.error.tolist(), strict=True)},
        "measured_less_fitted": fit.residual.tolist(), "points_outside_of_curves": fit.beyond,
        "trend": [one._asdict() for one in fit.trend],
    }  # fmt: skip


def shown(found: OverDepth, points: Mapping[str, Points], fits: Mapping[str, FrictionFit]) -> Iterator[Table | str]:
    """Loads at the depth of the scene, and the factors of friction that the measured points mean."""
    units = found.scene.unit_system
    rows = (
        (f"{friction:.3g}", *("locked" if math.isnan(load) else units.number(load, "force")
                              for load in found.hookload[:, f, -1].tolist()),
         units.number(found.torque[f, -1], "torque"))
        for f, friction in enumerate(found.friction.tolist())
    )  # fmt: skip
    depth = units.text(found.scene.length, "length")
    yield Table(
        ("friction", *(one.name for one in found.operations), "torque"), rows, right=range(5),
        title=f"{found.scene.name}, soft string, bit at {depth}: hookload in {units.force}, torque off bottom in "
        f"{units.torque}" + "; locked: friction holds the string" * bool(np.isnan(found.hookload[:, :, -1]).any()),
    )  # fmt: skip
    for load, fit in fits.items():
        yield f"measured {load}: {_said(found, fit)}"
    if (weight := points.get("off bottom")) is not None and weight.value.size:
        curve = np.interp(weight.depth, found.depth, found.curves("off bottom")[0][0])
        yield (
            f"measured off bottom: {units.text(float(np.mean(weight.value - curve)), 'force', '+.3g')} beside the "
            "computed weight (mean); a constant error moves the factors of trip out and trip in in opposite ways"
        )
    for load, one in points.items():
        if one.left_out:
            yield f"measured {load}: left out, {one.left_out}"
        if one.on_bottom:
            yield (
                f"measured {load}: {one.on_bottom} rows with more than {units.text(ON_BOTTOM, 'force')} on the bit "
                "left out, the curves are of a bit off bottom"
            )
    trends = [
        (load, units.span(one.top, one.bottom, "length"), str(one.points), one.part, f"{one.friction:.3f}",
         f"{one.error:.2g}")
        for load, fit in fits.items() for one in fit.trend
    ]  # fmt: skip
    if trends:
        yield Table(
            ("measured", "bit at", "points", "factor", "friction", "+-"), trends, right=(2, 4, 5),
            title="trend: factor that the points of a range of depth have, the other one as fitted to all",
        )  # fmt: skip


def _said(found: OverDepth, fit: FrictionFit) -> str:
    """Sentence on a fit."""
    count, low, high = fit.residual.size, found.friction[0], found.friction[-1]
    if not fit.parts:
        return f"no load of these {count} points depends on friction"
    values = ", ".join(
        f"{PARTS[part]} {value:.3g}{' (at its bound)' * (value in {0.0, LARGEST})}"
        + (f" +- {error:.2g}" if math.isfinite(error) else ", error not known")
        for part, value, error in zip(fit.parts, fit.friction.tolist(), fit.error.tolist(), strict=True)
    )
    text = f"friction {values} (least squares, {count} points, 95 %)"
    if fit.apart.size:
        alone = " and ".join(f"{error:.2g}" for error in fit.apart) if np.isfinite(fit.apart).all() else ""
        text += "; these points cannot tell cased from open" + (f": errors of {alone} if fitted apart" if alone else "")
    elif found.casing and len(fit.parts) == 1:
        text += f"; no point tells the {'open hole' if fit.parts == ('cased',) else 'casing'}"
    if fit.beyond:
        text += f"; {fit.beyond} points outside of the curves, counted"
    if ((fit.friction < low) | (fit.friction > high)).any():
        text += f"; outside of --friction, {low:.3g} to {high:.3g}"
    return text


def broomstick(found: OverDepth, points: Mapping[str, Points], fits: Mapping[str, FrictionFit]) -> Figure:
    """Hookload and torque over the depth of the bit, a line a coefficient, measured points, and fits (dashed)."""
    units, colours = found.scene.unit_system, {"trip out": VERMILION, "trip in": BLUE, "off bottom": GREEN}
    depth, bottom = units.show(found.depth, "length"), float(units.show(found.scene.length, "length"))
    shades = np.linspace(0.35, 1.0, found.friction.size)
    with styled():
        friction = f"{found.friction[0]:.3g} to {found.friction[-1]:.3g}"
        figure = blank(7.2, f"{found.scene.name}: loads over the depth of the bit, friction {friction}")
        load, torque = (figure.add_axes((0.08 + 0.5 * k, 0.085, 0.4, 0.76)) for k in range(2))
        for operation, rows in zip(found.operations, found.hookload, strict=True):
            colour = colours[operation.name]
            many = [(rows[0], 1.0)] if operation.rotation else zip(rows, shades.tolist(), strict=True)
            for row, shade in many:
                load.plot(units.show(row, "force"), depth, color=colour, alpha=shade, linewidth=1.4)
            load.plot([], [], color=colour, label=operation.name)
        for row, shade, value in zip(found.torque, shades.tolist(), found.friction.tolist(), strict=True):
            torque.plot(units.show(row, "torque"), depth, color=GREEN, alpha=shade, linewidth=1.4)
            torque.annotate(f"{value:.3g}", (units.show(row[-1], "torque"), bottom), xytext=(0, -3), fontsize=8.5,
                            textcoords="offset points", ha="center", va="top", color=INK)  # fmt: skip
        for name, one in points.items():
            panel, quantity = (torque, "torque") if name == "torque" else (load, "force")
            colour = colours.get(name, GREEN)
            panel.plot(
                units.show(one.value, quantity), units.show(one.depth, "length"), "o",
                color=colour, markersize=5, markeredgecolor=INK, label=f"{name}, measured",
            )  # fmt: skip
            if name in fits:
                order = np.argsort(one.depth)
                fitted = units.show((one.value - fits[name].residual)[order], quantity)
                panel.plot(fitted, units.show(one.depth[order], "length"), color=INK, linestyle="--", linewidth=1.0)
        for panel, name, quantity in ((load, "hookload", "force"), (torque, "torque off bottom", "torque")):
            panel.set(xlabel=f"{name} [{getattr(units, quantity)}]", ylim=(1.05 * bottom, 0.0), xlim=(0.0, None))
        load.set_ylabel(f"depth of the bit [{units.length}]")
        for panel in (load, torque) if "torque" in points else (load,):
            panel.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
        notes = "darker: more friction" + "; dashed: fitted" * bool(fits)
        figure.text(0.975, 0.955, notes, ha="right", fontsize=9)
    return figure
