# SPDX-License-Identifier: Apache-2.0
"""The string in the well at the end of the run: the hole as it is drilled, and tracks over measured depth.

Forces along the string follow from its recorded shape; points are what the bag holds at the two ends.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.dynamics.discretisation.discretise import contact_radius
from drill_twin.report.figures.style import BLUE, GREY, INK, LIGHT, VERMILION, blank
from drill_twin.report.recording import Recording
from drill_twin.report.string_curve import VERTICAL, low_side
from drill_twin.report.string_forces import string_forces

_WIDE = 0.05
"""Radius of the hole in the section as drawn, over the size of the well."""
_LEGEND = 24.0
"""Height of the legend between section and title, however flat the section is [points]."""
_POINTS = 800


def well(recording: Recording) -> Figure:
    """Vertical section; tracks of string and hole towards the low side, distance to the wall and forces."""
    scene, units = recording.scene, recording.units
    figure = blank(6.8, f"The string in the well at {recording.duration:.2f} s")
    depth = np.linspace(0.0, scene.length, _POINTS)
    hole = np.array([scene.hole.radius_at(at) for at in depth.tolist()])
    pipe, (low, angle) = contact_radius(scene, scene.length - depth), low_side(scene, depth)
    inclined, offset = bool(np.abs(low).max() > VERTICAL), _offset(recording, depth)
    along = (offset * np.conj(_directions(low))).real
    right = -1.0 if inclined else 1.0  # the low side of a hole that builds to the right is on its left
    panel = figure.add_axes((0.065, 0.09, 0.22, 0.775))
    deep, wide, thick, off = (units.show(row, "length") for row in (depth, hole, pipe, right * along))
    _section(panel, angle, deep, wide, thick, off, units.length)
    places = ((0.36, 0.145), (0.53, 0.09), (0.65, 0.09), (0.77, 0.09), (0.89, 0.09))
    tracks = [figure.add_axes((left, 0.09, width, 0.775)) for left, width in places]
    across, gap, side, tension, torque = tracks
    _bands(across, deep, *(units.show(row, "offset") for row in (hole, pipe, along)))
    across.set(xlabel=f"{'low side' if inclined else 'x'} [{units.offset}]", ylabel=f"measured depth [{units.length}]")
    across.set_title(f"towards {'low side' if inclined else 'x'}", fontsize=10)
    gap.plot(
        units.show(hole - pipe - np.abs(offset), "offset"), deep, color=BLUE, linewidth=1.0, label="distance to wall"
    )
    gap.axvline(0.0, color=INK, linewidth=1.4)
    gap.set_xlabel(f"[{units.offset}]")
    gap.set_title("to the wall", fontsize=10)
    _forces(recording, side, tension, torque)
    for track in tracks:
        track.set_ylim(units.show(scene.length, "length"), 0.0)
        track.xaxis.set_major_locator(MaxNLocator(3 if track is across else 2))
        track.tick_params(labelleft=track is across)
    return figure


def _forces(recording: Recording, side: Axes, tension: Axes, torque: Axes) -> None:
    """Forces of the last pose as lines, forces recorded at top and bit as points."""
    rig, units = recording.rig, recording.units
    length = units.show(recording.scene.length, "length")
    ends = (rig.hookload[-1], -rig.bit_force[-1], rig.top_drive_torque[-1], -rig.bit_torque[-1]) if len(rig) else ()
    found = string_forces(recording, slice(-1, None))
    for panel, values, points, name, quantity in (
        (side, None if found is None else found.side[0], (), "side force", "force_per_length"),
        (tension, None if found is None else found.tension[0], ends[:2], "tension", "force"),
        (torque, None if found is None else found.torque[0], ends[2:], "torque", "torque"),
    ):
        if found is not None and values is not None:
            steps = units.show(np.repeat(found.depth, 2)[1:-1], "length")  # one value an element
            panel.plot(units.show(np.repeat(values, 2), quantity), steps, color=BLUE, linewidth=1.0, label=name)
        if points:
            panel.plot(
                units.show(np.array(points), quantity),
                (0.0, length),
                "o",
                color=VERMILION,
                clip_on=False,
                label="recorded",
            )
        panel.axvline(0.0, color=GREY, linewidth=0.8)
        panel.margins(x=0.15)
        panel.set(xlabel=f"[{getattr(units, quantity)}]")
        panel.set_title(name, fontsize=10)


def _directions(low: ComplexArray) -> ComplexArray:
    """Unit direction of the low side; where the hole is vertical, the nearest inclined place's direction, else x."""
    if not (known := np.flatnonzero(np.abs(low) > VERTICAL)).size:
        return np.ones(low.size, complex)
    nearest = known[np.abs(np.arange(low.size)[:, None] - known).argmin(axis=1)]
    return np.asarray(low[nearest] / np.abs(low[nearest]))


def _offset(recording: Recording, depth: Array) -> ComplexArray:
    """Offset x + i y of the centre line from the axis at the last pose [m]."""
    curve = recording.shapes()[-1]
    curve = curve[np.argsort(-curve[:, 2])]
    return np.asarray(np.interp(depth, -curve[:, 2], curve[:, 0] + 1j * curve[:, 1]))


def _section(panel: Axes, angle: Array, depth: Array, hole: Array, pipe: Array, along: Array, unit: str) -> None:
    """Vertical section along the hole, its azimuth unrolled; hole and string are drawn wider than they are."""
    middle, step = 0.5 * (angle[1:] + angle[:-1]), np.diff(depth)
    out = np.append(0.0, np.cumsum(step * np.sin(middle)))
    down = np.append(0.0, np.cumsum(step * np.cos(middle)))
    size = max(float(np.ptp(out)), float(np.ptp(down)))
    wider = _WIDE * size / float(hole.max())

    def shifted(distance: Array) -> tuple[Array, Array]:
        """Points at a distance from the axis, positive towards the right of a hole that goes down."""
        return out + wider * distance * np.cos(angle), down - wider * distance * np.sin(angle)

    bands: tuple[tuple[Array, Array, dict[str, Any]], ...] = (
        (-hole, hole, {"facecolor": LIGHT, "label": "hole"}),
        (along - pipe, along + pipe, {"facecolor": BLUE, "label": "string"}),
        (-hole, hole, {"facecolor": "none", "edgecolor": INK, "linewidth": 1.4}),  # on top: it holds the string
    )
    for near, far, looks in bands:
        left, right = shifted(near), shifted(far)
        panel.fill(np.append(left[0], right[0][::-1]), np.append(left[1], right[1][::-1]), **looks)
    room = 0.5 * size + 1.6 * _WIDE * size
    centre = 0.5 * float(out.max() + out.min())
    panel.set(
        xlim=(centre - 0.62 * room, centre + 0.62 * room) if np.ptp(out) < 0.4 * size else None, aspect="equal",
        ylim=(float(down.max()) + 1.6 * _WIDE * size, float(down.min()) - 1.6 * _WIDE * size),
        xlabel=f"along the section [{unit}]", ylabel=f"vertical depth [{unit}]",
    )  # fmt: skip
    panel.yaxis.labelpad = 1.0
    panel.set_title(f"widths drawn {wider:.3g} times", fontsize=10, pad=_LEGEND)
    panel.xaxis.set_major_locator(MaxNLocator(3))
    panel.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.2)


def _bands(panel: Axes, depth: Array, hole: Array, pipe: Array, along: Array) -> None:
    """Hole and string over measured depth, positive towards the low side."""
    panel.fill_betweenx(depth, -hole, hole, color=LIGHT)
    for side in (-1.0, 1.0):
        panel.plot(side * hole, depth, color=INK, linewidth=1.4, zorder=3)  # on top: it holds the string
    panel.fill_betweenx(depth, along - pipe, along + pipe, color=BLUE, alpha=0.35, linewidth=0)
    panel.plot(along, depth, color=BLUE, linewidth=1.0)
