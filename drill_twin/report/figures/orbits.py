# SPDX-License-Identifier: Apache-2.0
"""Orbits of the centre line in the cross-section of the hole, seen from above, and shapes of the string in 3-D.

Orbits have a panel a depth. A panel shows the whole hole or, where the motion is small, the enlarged orbit with the
whole hole beside it.
"""

import math
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.report.figures.style import BLUE, GREY, INK, LIGHT, VERMILION, WIDTH, blank, mark_style, note
from drill_twin.report.recording import Recording
from drill_twin.report.string_curve import FLAT, VERTICAL, assembly_top, low_side

COLUMNS = 4
MAP = "cividis_r"
_SEGMENTS = 6000
"""Most line segments of an orbit."""
SMALL = 0.25
"""Share of the hole's radius below which a motion is enlarged."""
_MARGIN = 1.07
_SMALLEST = 1e-3
"""Least half-width of a panel, in the unit of its axes."""


def orbits(recording: Recording) -> Figure:
    """Wall (thick), limit of the centre line (dotted), the pipe at its size, and the orbit, coloured by time."""
    depths = by_depth(recording)
    columns = min(COLUMNS, len(depths))
    side, top, bottom, gap = min(WIDTH * 0.95 / columns, 4.2), 0.7, 0.85, 0.3
    height = math.ceil(len(depths) / columns) * (side + gap) + top + bottom
    figure = blank(height, "Orbits of the centre line across the hole, seen from above")
    norm, unit = Normalize(0.0, recording.duration), recording.units.offset
    left = 0.5 * (1.0 - columns * side / WIDTH) + 0.015
    for number, marks in enumerate(depths):
        row, column = divmod(number, columns)
        rectangle = (
            left + (column * side + 0.16 * side) / WIDTH,
            1.0 - (top + row * (side + gap) + 0.85 * side) / height,
            0.82 * side / WIDTH,
            0.82 * side / height,
        )
        panel = figure.add_axes(rectangle)
        _orbits_at(panel, recording, marks, norm)
        panel.set_ylabel(f"y [{unit}]" if column == 0 else "", labelpad=1)
        panel.set_xlabel(f"x [{unit}]" if number + columns >= len(depths) else "", labelpad=1)
    bar = figure.add_axes((0.3, 0.52 / height, 0.4, 0.11 / height))
    figure.colorbar(ScalarMappable(norm, MAP), cax=bar, orientation="horizontal", label="time [s]")
    if (onset := recording.summary.onset) is not None:
        bar.axvline(onset.time_s, color=INK, linewidth=1.4, linestyle=(0, (2, 1)))
        looks = {"ha": "center", "va": "bottom", "fontsize": 9}
        note(bar, "onset", (onset.time_s, 1.0), where=("data", "axes fraction"), shift=(0, 2), **looks)
    return figure


def by_depth(recording: Recording) -> list[list[int]]:
    """Numbers of the marks at each distance from the bit, in the scene's order."""
    found: dict[float, list[int]] = {}
    for number, place in enumerate(recording.places):
        found.setdefault(place.distance_from_bit, []).append(number)
    return list(found.values())


def _orbits_at(panel: Axes, recording: Recording, marks: list[int], norm: Normalize) -> None:
    """Orbits of the marks at one depth."""
    places, scene, units = [recording.places[mark] for mark in marks], recording.scene, recording.units
    distance = places[0].distance_from_bit
    wall = units.show(scene.hole.radius_at(max(scene.length - distance, 0.0)), "offset")
    centre = units.show(recording.centre_lines()[:, marks], "offset")
    pipe = wall - units.show(places[0].clearance, "offset")
    largest = max(float(np.nanmax(np.abs(centre), initial=0.0)), _SMALLEST)
    edge = _MARGIN * wall
    panel.set_facecolor(LIGHT)
    _hole(panel, wall, pipe, centre[-1, 0])
    title = f"{', '.join(place.name for place in places)}, {units.text(distance, 'length')} from bit"
    if largest < SMALL * wall:
        beside = panel.inset_axes((0.69, 0.69, 0.3, 0.3))
        _hole(beside, wall, pipe, centre[-1, 0])
        _limits(beside, edge)
        beside.set_axis_off()
        edge = 1.6 * largest
        title += f"\nenlarged {_MARGIN * wall / edge:.2g} times"
    for column in range(len(marks)):
        _path(panel, recording.marks.time, centre[:, column], norm)
    _limits(panel, edge)
    _mark_low_side(panel, complex(low_side(scene, np.array([scene.length - distance]))[0][0]))
    panel.grid(visible=False)
    panel.tick_params(labelsize=8.5)
    panel.set_title(title, fontsize=9.5, loc="center", pad=4)


def _mark_low_side(panel: Axes, low: complex) -> None:
    """Arrow to the low side; none in a vertical hole."""
    if abs(low) < VERTICAL:
        return
    way = low / abs(low)
    panel.annotate(
        "low side", (0.5 + 0.49 * way.real, 0.5 + 0.49 * way.imag), (0.5 + 0.36 * way.real, 0.5 + 0.36 * way.imag),
        xycoords="axes fraction", ha="center", va="center", fontsize=8, color=VERMILION,
        arrowprops={"arrowstyle": "-|>", "color": VERMILION},
    )  # fmt: skip


def _limits(panel: Axes, edge: float) -> None:
    panel.set(xlim=(-edge, edge), ylim=(-edge, edge), aspect="equal")


def _hole(panel: Axes, wall: float, pipe: float, centre: complex) -> None:
    """Cross-section of the hole with the pipe at its last position."""
    panel.add_patch(Circle((0.0, 0.0), wall, facecolor="white", edgecolor=INK, linewidth=1.8, zorder=1))
    panel.add_patch(Circle((0.0, 0.0), wall - pipe, fill=False, edgecolor=GREY, linewidth=0.9, linestyle=":", zorder=3))
    if np.isfinite(centre):
        at = (centre.real, centre.imag)
        panel.add_patch(Circle(at, pipe, facecolor=BLUE, alpha=0.18, linewidth=0, zorder=2, label="pipe"))
        panel.add_patch(Circle(at, pipe, fill=False, edgecolor=BLUE, linewidth=1.2, zorder=4))


def _path(panel: Axes, time: Array, centre: ComplexArray, norm: Normalize) -> None:
    every = max(1, time.size // _SEGMENTS)
    points = np.column_stack((centre.real, centre.imag))[::every]
    lines = LineCollection(list(np.stack((points[:-1], points[1:]), axis=1)), cmap=MAP, norm=norm, linewidth=0.9)
    lines.set(array=time[::every][:-1], zorder=3)
    panel.add_collection(lines)
    panel.plot([points[-1, 0]], [points[-1, 1]], "o", color=INK, markersize=3.5, zorder=5)


_SHAPES = 9
_REVOLUTIONS = 2.0
"""Length of the paths of the marks at the end of the run, in revolutions of rotation or whirl, the slower one."""


def string_shapes(recording: Recording) -> Figure:
    """Left: shapes over the run; right: the last revolutions, with the paths of the marks. Lateral axes stretched.

    Of a string of more than `FLAT` the assembly, flat.
    """
    if recording.scene.length > FLAT:
        return _flat_shapes(recording)
    figure = blank(6.6, "The string in the hole (lateral axes stretched)")
    time, units = recording.poses.time, recording.units
    shapes = recording.shapes() * units.show(1.0, "offset")
    shapes[..., 2] *= units.show(1.0, "length") / units.show(1.0, "offset")
    last = float(time[-1])
    since = last - _window(recording)
    norm = Normalize(0.0, last)
    run, end = (_box(figure, recording, side) for side in (0, 1))
    for instant in np.linspace(float(time[0]), last, _SHAPES):
        shape = shapes[int(np.argmin(np.abs(time - instant)))]
        run.plot(*shape.T, color=mpl.colormaps[MAP](norm(instant)), linewidth=1.6)
    for instant in np.linspace(since, last, _SHAPES):
        shape = shapes[int(np.argmin(np.abs(time - instant)))]
        end.plot(*shape.T, color=INK, linewidth=2.0 if instant == last else 0.8, alpha=1.0 if instant == last else 0.3)
    _paths(end, recording, since)
    figure.legend(*end.get_legend_handles_labels(), loc="upper right", bbox_to_anchor=(0.985, 0.995), ncols=6)
    for side, text in enumerate(
        (
            f"{_SHAPES} shapes over the run{', the curved hole drawn straight' if recording.scene.hole.survey else ''}",
            f"the last {last - since:.1f} s, and the marks' paths",
        )
    ):
        figure.text(0.275 + 0.465 * side, 0.905, text, ha="center", fontsize=11.5)
    bar = figure.add_axes((0.036, 0.3, 0.011, 0.4))
    figure.colorbar(ScalarMappable(norm, MAP), cax=bar)
    bar.set_title("time [s]", loc="center", fontsize=9.5)
    return figure


def _flat_shapes(recording: Recording) -> Figure:
    """Assembly of a long string: distance from the axis over measured depth, over the run and at its end."""
    scene, units, time, shapes = recording.scene, recording.units, recording.poses.time, recording.shapes()
    figure, last = blank(6.6, "The assembly in the hole, by its distance from the axis"), float(time[-1])
    depth = np.linspace(assembly_top(scene), scene.length, 200)
    hole = units.show(np.array([scene.hole.radius_at(at) for at in depth.tolist()]), "offset")
    window, deep = _window(recording), units.show(depth, "length")
    for side, begin in enumerate((float(time[0]), last - window)):
        text = f"the last {window:.1f} s" if side else f"{_SHAPES} shapes over the run, the darker the later"
        figure.text(0.085 + 0.48 * side, 0.88, text, fontsize=11.5)
        for axis, name in enumerate("xy"):
            panel = figure.add_axes((0.085 + 0.48 * side + 0.22 * axis, 0.1, 0.19, 0.75))
            panel.fill_betweenx(deep, -hole, hole, color=LIGHT)
            for instant in np.linspace(begin, last, _SHAPES):
                shape = shapes[int(np.argmin(np.abs(time - instant)))]
                colour = mpl.colormaps[MAP]((instant - begin) / max(last - begin, 1e-9))
                panel.plot(units.show(shape[:, axis], "offset"), units.show(-shape[:, 2], "length"), color=colour)
            panel.set(xlabel=f"{name} [{units.offset}]", xlim=(-1.1 * hole.max(), 1.1 * hole.max()))
            panel.set_ylim(deep[-1], deep[0])
            panel.xaxis.set_major_locator(MaxNLocator(3))
            panel.tick_params(labelleft=not axis and not side)
    figure.axes[0].set_ylabel(f"measured depth [{units.length}]")
    return figure


def _window(recording: Recording) -> float:
    """Time of the last revolutions [s]."""
    summary = recording.summary
    rates = [abs(rate) for rate in (summary.whirl_frequency_hz, summary.rotation_rev_s) if rate]
    return min(_REVOLUTIONS / min(rates, default=1.0), 0.5 * recording.duration)


def _paths(panel: Any, recording: Recording, since: float) -> None:
    time, units = recording.marks.time, recording.units
    centre, chosen = units.show(recording.centre_lines(), "offset"), time >= since
    height = units.show(recording.marks.position[..., 2], "length")
    for mark, place in enumerate(recording.places):
        z = centre[chosen, mark]
        panel.plot(z.real, z.imag, height[chosen, mark], label=place.name, **mark_style(mark), linewidth=1.6)


def _box(figure: Figure, recording: Recording, side: int) -> Any:
    """3-D axes with rings at the wall; z = 0 is the top clamp."""
    panel: Any = figure.add_axes((0.045 + 0.465 * side, 0.0, 0.48, 0.93), projection="3d")
    hole, length, units = recording.scene.hole, recording.scene.length, recording.units
    depths = [*np.linspace(0.0, length, 6), *(end for step in hole.intervals for end in (step.top, step.bottom))]
    radii = {
        units.show(depth, "length"): units.show(hole.radius_at(float(depth)), "offset")
        for depth in depths if depth <= length
    }  # fmt: skip
    radius = max(radii.values())
    angle = np.linspace(0.0, math.tau, 73)
    for depth, wall in radii.items():
        ring = (wall * np.cos(angle), wall * np.sin(angle), np.full_like(angle, -depth))
        panel.plot(*ring, color=GREY, linewidth=0.6, alpha=0.7)
    panel.set_box_aspect((1.0, 1.0, 1.9), zoom=1.0)
    panel.view_init(elev=18, azim=-58)
    panel.set(
        xlim=(-radius, radius), ylim=(-radius, radius), zlim=(-units.show(length, "length"), 0.0),
        xlabel=f"x [{units.offset}]", ylabel=f"y [{units.offset}]", zlabel=f"z [{units.length}]",
    )  # fmt: skip
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(MaxNLocator(3))
    for axis in (panel.xaxis, panel.yaxis, panel.zaxis):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.line.set_color(LIGHT)
    panel.tick_params(labelsize=9, colors=INK)
    return panel
