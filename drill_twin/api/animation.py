# SPDX-License-Identifier: Apache-2.0
"""Moving picture of a run: the string in its hole over depth, and the orbits of its marks, as GIF or MP4."""

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError
from drill_twin.core.files.output import make_folder
from drill_twin.dynamics.discretisation.discretise import contact_radius
from drill_twin.report.figures.style import BLUE, GREY, INK, LIGHT, ORANGE, blank, mark_style, styled
from drill_twin.report.string_curve import FLAT, along_hole, assembly_top, smooth

LAST, RATE, TRAIL = 10.0, 12, 1.5
"""Time at the end of a run that is shown [s], frames per second, length of an orbit's path [s]."""
_ORBITS = 4


def animate(result: Any, path: str | Path, begin: float | None, end: float | None, speed: float) -> Path:
    """Write the moving picture; the arguments are explained at `Result.animate`."""
    from matplotlib import animation

    file = Path(path)
    if file.suffix not in {".gif", ".mp4"}:
        raise ArgumentError(f'path: expected a file such as "run.gif" or "run.mp4", found "{file.name}"')
    if file.suffix == ".mp4" and not animation.writers.is_available("ffmpeg"):
        raise ArgumentError("path: expected ffmpeg on the PATH for an .mp4, found none; write a .gif")
    if not len(result.string) or not result.recording.places:
        raise ArgumentError("expected poses of the string and marks in the recording, found none")
    last = float(result.string.time[-1]) if end is None else end
    first = max(0.0, last - LAST) if begin is None else begin
    if not (first < last and speed > 0.0):
        raise ArgumentError(f"begin, end: expected a begin before the end, found {first:g} and {last:g} s")
    make_folder(file.parent)
    with styled():
        picture = _Picture(result)
        instants = np.arange(first, last, speed / RATE)
        moving = animation.FuncAnimation(picture.figure, picture.draw, frames=instants.tolist(), blit=False)
        writer: Any = animation.PillowWriter if file.suffix == ".gif" else animation.FFMpegWriter
        moving.save(file, writer=writer(fps=RATE), dpi=80)
    return file


class _Picture:
    """Figure whose lines move: across the hole over depth towards x and y, and orbits of the marks."""

    def __init__(self, result: Any) -> None:
        recording, scene = result.recording, result.scene
        self.result, self.units = result, recording.units
        self.top = assembly_top(scene) if scene.length > FLAT else 0.0
        self.centre = self.units.show(result.centre, "offset")
        self.figure = blank(5.2)
        self.depth = depth = np.linspace(self.top, scene.length, 300)
        hole = self._offset(np.array([scene.hole.radius_at(at) for at in depth.tolist()]))
        self.pipe, self.lines = self._offset(contact_radius(scene, scene.length - depth)), []
        for side, axis in enumerate("xy"):
            panel = self.figure.add_axes((0.075 + 0.15 * side, 0.11, 0.13, 0.74))
            panel.fill_betweenx(self.units.show(depth, "length"), -hole, hole, color=LIGHT)
            bands = [panel.plot([], [], color=BLUE, linewidth=width)[0] for width in (0.8, 2.0, 0.8)]
            panel.set(xlim=(-1.1 * hole.max(), 1.1 * hole.max()), xlabel=f"{axis} [{self.units.offset}]")
            panel.set_ylim(self.units.show(scene.length, "length"), self.units.show(self.top, "length"))
            panel.tick_params(labelleft=side == 0)
            panel.xaxis.set_major_locator(MaxNLocator(2))
            self.lines.append(bands)
        self.figure.axes[0].set_ylabel(f"measured depth [{self.units.length}]")
        self.orbits = [self._orbit(number) for number in range(min(_ORBITS, len(recording.places)))]
        self.title = self.figure.text(0.012, 0.95, "", fontsize=12, fontweight="bold", color=INK)

    def _offset(self, values: Array) -> Array:
        return np.asarray(self.units.show(values, "offset"))

    def _orbit(self, number: int) -> tuple[Any, Any]:
        """Panel of a mark with the wall for its centre, and the lines of its path and place."""
        place = self.result.recording.places[number]
        row, column = divmod(number, 2)
        panel = self.figure.add_axes((0.42 + 0.29 * column, 0.50 - 0.42 * row, 0.27, 0.35))
        clearance, turn = float(self.units.show(place.clearance, "offset")), np.linspace(0.0, math.tau, 120)
        panel.plot(clearance * np.cos(turn), clearance * np.sin(turn), color=GREY, linewidth=1.2)
        panel.set(aspect="equal", xlim=(-1.1 * clearance, 1.1 * clearance), ylim=(-1.1 * clearance, 1.1 * clearance))
        panel.set_title(f"{place.name}, clearance {self.units.text(place.clearance, 'offset')}", fontsize=9.5)
        panel.set_axis_off()
        path = panel.plot([], [], **{**mark_style(number), "linestyle": "-"}, linewidth=1.2)[0]
        return path, panel.plot([], [], "o", color=ORANGE, markersize=6)[0]

    def draw(self, now: float) -> list[Any]:
        """Move the lines to a time [s]."""
        result, units, poses = self.result, self.units, self.result.string
        at = int(np.argmin(np.abs(poses.time - now)))
        curve = along_hole(result.scene, smooth(poses.position[at : at + 1], poses.tangent[at : at + 1]))[0]
        curve = curve[np.argsort(-curve[:, 2])]
        for axis, bands in enumerate(self.lines):
            middle = self._offset(np.interp(self.depth, -curve[:, 2], curve[:, axis]))
            for band, shift in zip(bands, (-1.0, 0.0, 1.0), strict=True):
                band.set_data(middle + shift * self.pipe, units.show(self.depth, "length"))
        time = result.marks.time
        first, last = np.searchsorted(time, (now - TRAIL, now)).tolist()
        last = min(last, time.size - 1)
        for number, (path, place) in enumerate(self.orbits):
            path.set_data(*self.centre[first : last + 1, number].T)
            place.set_data(self.centre[last : last + 1, number, 0], self.centre[last : last + 1, number, 1])
        row = min(int(np.searchsorted(result.time, now)), result.time.size - 1)
        at_work = ""
        if len(result.rig):
            at_work = f", {units.set_point(float(result.weight_on_bit[row]), float(result.rig.top_drive_speed[row]))}"
        motion = [period.state.value for period in result.recording.summary.motion if period.start_s <= now]
        self.title.set_text(f"{result.scene.name}: {now:.2f} s{at_work}{f', {motion[-1]}' if motion else ''}")
        return []
