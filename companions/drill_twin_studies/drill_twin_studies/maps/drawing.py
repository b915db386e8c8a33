# SPDX-License-Identifier: Apache-2.0
"""Map for people: lines of text, colours and geometry, figure, and the page, one HTML file that opens from disk."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from importlib.resources import files
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from drill_twin.core import __version__
from drill_twin.core.arrays import Array, Mask
from drill_twin.core.severity import Grade
from drill_twin.io.messages.topic_words import REGIME_COLOURS
from drill_twin.scene import Scene
from drill_twin.scene.load import parse_scene
from drill_twin_studies.maps.operating_map import OperatingMap
from drill_twin_studies.maps.plane import Labels, depth, on_lattice
from drill_twin_studies.maps.regimes import REGIMES, Regime

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WINDOW_COLOUR = "#00432f"
"""Colour of the edges of the calm windows."""
GRADE_COLOURS = ("#f2f2ee", "#fff3a6", "#fdbb63", "#e8553a", "#7f0010", "#9a9a9a")
"""Colours of the grades of severity, and of a severity that is not known (after ColorBrewer's YlOrRd)."""
GRADES = (*(grade.word for grade in Grade), "unknown")


class Boundary(NamedTuple):
    """Boundary of a field of the map."""

    label: str
    """Words of the legend."""
    segments: list[list[list[float]]]
    """Segments of two points, weight on bit [N] and speed [rad/s]."""
    colour: str
    """Colour of the line."""
    style: str
    """Style of the line: solid, dashed or dotted."""
    width: float
    """Width of the line [points]."""


def boundaries(found: OperatingMap) -> list[Boundary]:
    """Lines of a map; the onset of whirl is the last, above the others."""
    lines = []
    if len(found.growth):
        lines.append(Boundary("straight string: growth 0", found.lines(grows(found)), "#0072b2", "dotted", 1.8))
    if found.has_second_boundary:
        ends = found.lines(found.keeps_whirling)
        lines.append(Boundary("an existing whirl dies or creeps", ends, "#000000", "dashed", 1.8))
    lines.append(Boundary("whirl begins from rest", found.lines(found.whirls), "#000000", "solid", 2.2))
    return [line for line in lines if line.segments]


def grows(found: OperatingMap) -> Mask:
    """Nodes at which a mode of the linear string grows."""
    return np.asarray(on_lattice(np.array(found.growth, float), found.plane.steps) > 0.0)


def margins(flags: Mask) -> tuple[Array, Array, Array]:
    """Distances from each node to the boundary of flagged nodes [steps]: along each range, and the shortest.

    The distances equal `OperatingMap.margin` without the sign; infinite where there is no boundary.
    """
    along = [np.apply_along_axis(_to_the_others, axis, flags) for axis in (0, 1)]
    return along[0], along[1], _to_the_others(flags)


def _to_the_others(flags: Mask) -> Array:
    """Distance from each node to the boundary half-way to the nearest node that is flagged otherwise."""
    return np.asarray(np.where(flags, depth(flags), depth(~flags)) - 0.5)


def map_figure(found: OperatingMap) -> Figure:
    """Regimes and severity over speed and weight on bit, the runs, the boundaries and the calm windows."""
    from matplotlib.patches import Patch

    from drill_twin.report.figures.style import laid_out, styled

    with styled():
        figure = laid_out(5.6, f"{found.name}: {found.said_runs}")
        kinds, severity = figure.subplots(1, 2, sharey=True)
        kinds.set_ylabel(f"weight on bit [{found.units.force}]")
        fields = (
            (kinds, "motion", found.regimes, REGIME_COLOURS),
            (severity, "severity", found.severities, GRADE_COLOURS),
        )
        for axes, title, labels, colours in fields:
            axes.set_title(title, loc="left")
            axes.set_xlabel(f"speed [{found.units.rotation}]")
            axes.grid(visible=False)
            _draw(axes, found, labels % len(colours), colours)
        there = np.unique(found.regimes).tolist()
        regimes = [Patch(color=REGIME_COLOURS[code], label=REGIMES[code].value) for code in there]
        regimes += [Patch(color=GRADE_COLOURS[code], label=f"severity: {GRADES[code]}")
                    for code in np.unique(found.severities).tolist()]  # fmt: skip
        if not found.known.all():
            regimes.append(Patch(facecolor="white", edgecolor="black", hatch="///", label="not known, nearest run"))
        handles = [*regimes, *kinds.get_legend_handles_labels()[0]]
        figure.legend(handles=handles, loc="outside lower left", ncols=4)
    return figure


def _draw(axes: Axes, found: OperatingMap, labels: Labels, colours: Sequence[str]) -> None:
    from matplotlib.collections import LineCollection
    from matplotlib.colors import BoundaryNorm, ListedColormap

    plane = found.plane
    scale = np.array([1.0 / found.units.show(1.0, "force"), 1.0 / found.units.show(1.0, "rotation")])

    def shown(points: ArrayLike) -> Array:
        """Speed and weight on bit in units of the axes, from weight and speed in SI, shape (..., 2)."""
        return np.asarray((np.asarray(points, float) / scale)[..., ::-1])

    (left, low), (right, high) = shown([plane.command((0, 0)), plane.command((plane.steps,) * 2)]).tolist()
    half = np.array([right - left, high - low]) / plane.steps / 2.0
    axes.imshow(
        labels, origin="lower", aspect="auto", interpolation="nearest", cmap=ListedColormap(colours),
        norm=BoundaryNorm(np.arange(len(colours) + 1) - 0.5, len(colours)),
        extent=(left - half[0], right + half[0], low - half[1], high + half[1]),
    )  # fmt: skip
    if not found.known.all():
        speeds, weights = (np.linspace(*ends, plane.steps + 1) for ends in ((left, right), (low, high)))
        middles = [0.5 * (nodes[1:] + nodes[:-1]) for nodes in (speeds, weights)]
        axes.contourf(*middles, ~found.known, levels=[0.5, 1.5], colors="none", hatches=["///"])
    for line in boundaries(found):
        segments = [shown(ends) for ends in line.segments]
        axes.add_collection(
            LineCollection(segments, colors=line.colour, linestyles=line.style, linewidths=line.width, label=line.label)
        )
    for label, failed, style, size, colour in (("runs", False, ".", 4.0, "black"), ("", True, "x", 5.0, "white")):
        runs = [plane.command(node) for node, made in found.runs_at_nodes.items()
                if (made[0].regime is Regime.FAILED) == failed]  # fmt: skip
        if runs:
            axes.plot(*shown(runs).T, style, color=colour, markersize=size, label=label, clip_on=False)
    for number, ((load, most), (slow, fast)) in enumerate(found.windows):
        x, y = shown([(load, slow), (most, slow), (most, fast), (load, fast), (load, slow)]).T
        axes.plot(x, y, color="white", linewidth=4.0)
        axes.plot(x, y, color=WINDOW_COLOUR, linewidth=2.0, label="" if number else "calm windows")
    rig = parse_scene(found.scene).rig
    if found.contains(rig.weight_on_bit.value, rig.rotation.value):
        place = shown([rig.weight_on_bit.value, rig.rotation.value])
        axes.plot(*place, "o", color="black", markerfacecolor="white", label="set-point of the scene")
    axes.set(xlim=(left, right), ylim=(low, high))


_LEFT_OUT = ("scene", "onset_boundary", "end_of_whirl_boundary")
"""Parts of `map.json` that the page has in another form, or not."""


def build_page(found: OperatingMap, scene: str) -> str:
    """HTML text of a map.

    Args:
        found: The map.
        scene: The scene with its options as on the command line, `pa6_bench --set hole.radius=80mm`, for the commands.
    """
    from drill_twin.report.page import html_page, scripts

    text = json.dumps(page_data(found, scene), allow_nan=False).replace("<", "\\u003c")
    here = files("drill_twin_studies.maps")
    body, code = ((here / name).read_text("utf-8") for name in ("page.html", "page.js"))
    return html_page(f"{found.name}: operating map", body, scripts({"map-data": text}, code))


def page_data(found: OperatingMap, scene: str) -> dict[str, Any]:
    """Data that the page draws: the map, its fields over the lattice, and the command of each run."""
    rig = parse_scene(found.scene).rig
    own = [rig.weight_on_bit.value, rig.rotation.value]
    return lattice_data(found) | {
        **{name: value for name, value in found.to_dict().items() if name not in _LEFT_OUT},
        "version": __version__,
        "own": own,
        "units": {
            quantity: [1.0 / found.units.show(1.0, quantity), getattr(found.units, quantity)]
            for quantity in ("force", "rotation", "torque", "stress")
        },
        "failed": Regime.FAILED.value,
        "whirling": [regime.value for regime in REGIMES if regime.whirls],
        "known": _digits(found.known),
        "calm": _digits(found.calm),
        "colours": REGIME_COLOURS,
        "grades": dict(zip(GRADES, GRADE_COLOURS, strict=True)),
        "window_colour": WINDOW_COLOUR,
        "boundaries": [line._asdict() for line in boundaries(found)],
        "margins": [_finite(field.ravel().tolist()) for field in margins(found.calm)],
        "own_margin": _finite(found.margin(*own) or [inf] * 3) if found.contains(*own) else [],
        "commands": [found.command_of(key, scene) for key in found.records],
    }


def lattice_data(found: OperatingMap) -> dict[str, Any]:
    """Ranges, calm window, and fields over the lattice as one hexadecimal digit a node: the map without its runs."""
    window = found.window
    return {
        "scene_name": found.name,
        "digest": found.digest,
        "weight_on_bit_N": list(found.plane.weight),
        "rotation_rad_s": list(found.plane.speed),
        "steps": found.plane.steps,
        "regimes": [regime.value for regime in REGIMES],
        "codes": "".join(f"{code:x}" for code in found.regimes.ravel().tolist()),
        "whirls": _digits(found.whirls),
        "keeps": _digits(found.keeps_whirling),
        "safe_window": None if window is None else [*window.weight, *window.speed],
    }


def _finite(values: Iterable[float]) -> list[float | None]:
    return [round(value, 6) if isfinite(value) else None for value in values]


def _digits(flags: Mask) -> str:
    return "".join("01"[flag] for flag in flags.ravel().tolist())


def shown(found: OperatingMap, scene: Scene) -> Iterator[str]:
    """Runs, windows, shares of the regimes and grades, and margin of the scene's own set-point."""
    units = scene.unit_system
    counts = Counter(found.regimes.ravel().tolist())
    yield f"{found.name}: {found.said_runs}"
    if not found.windows:
        yield "  no calm window: nowhere in these ranges do enough runs show that the string stays calm"
    for weight, speed in found.windows:
        at = units.span(speed.low, speed.high, "rotation")
        yield f"  calm window: {units.span(weight.low, weight.high, 'force')} at {at}"
    yield from (f"    rests on: {sentence}" for sentence in found.basis)
    whole = found.regimes.size
    for code, count in sorted(counts.items()):
        yield f"  {REGIMES[code].value}: {count / whole:.1%} of the ranges"
    grades = Counter(found.severities.ravel().tolist())
    yield "  severity: " + ", ".join(f"{GRADES[code]} {count / whole:.1%}" for code, count in sorted(grades.items()))
    unknown = 1.0 - float(found.known.mean())
    if unknown:
        yield f"  {unknown:.0%} of the ranges (hatched) lack runs on all sides; there the nearest run's motion stands"
    load, turn = scene.rig.weight_on_bit.value, scene.rig.rotation.value
    if found.contains(load, turn):
        margin, apart = found.margin(load, turn), ""
        if margin is not None and (far := margin.text(units)):
            apart = f"; {'margin to the boundary' if margin.share >= 0.0 else 'beyond the boundary by'} {far}"
        elif margin is None:
            apart = "; no margin, as no set-point of these ranges is calm"
        yield (
            f"  set-point of the scene, {units.set_point(load, turn)}: {found.regime(load, turn).value}"
            + ("" if found.is_known(load, turn) else " in the nearest run; not known there")
            + apart
        )
    yield from (f"  note: {note}" for note in found.notes)
