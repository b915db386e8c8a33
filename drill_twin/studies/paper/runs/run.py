# SPDX-License-Identifier: Apache-2.0
"""Run of a scene with the motion of its marks, and quantities measured by the analyzer and by the paper's method."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.errors import RunError
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.scene import Scene
from drill_twin.schedule import Schedule
from drill_twin.twin.twin import Twin
from drill_twin.whirl import Analyzer, Summary

FINER = 8
"""Zero padding: lines of the spectrum per resolved line."""


@dataclass(frozen=True, eq=False)
class Run:
    """Motion of the marks in a run; T frames, m marks. z is positive up from the top clamp."""

    time: Array
    """Times [s], shape (T,)."""
    point: Array
    """Marked points x, y, z [m], shape (T, m, 3); those on the surface of the pipe rotate with the spin."""
    velocity: Array
    """Their velocities [m/s], shape (T, m, 3)."""
    centre: Array
    """Centre line at the marks x, y, z [m], shape (T, m, 3)."""
    spin_rate: Array
    """Spin rate at the marks [rad/s], shape (T, m)."""
    names: tuple[str, ...]
    """Names of the marks."""
    summary: Summary
    """Summary of the analyzer."""
    wall_seconds: float
    """Wall-clock time of the physics [s]."""
    failure: str = ""
    """Reason why the run ended early; empty if it did not."""

    def index(self, mark: str) -> int:
        """Index of a mark."""
        return self.names.index(mark)

    @property
    def period(self) -> float:
        """Time between frames [s]."""
        return float(self.time[0])


def compile_for(scene: Scene) -> None:
    """Compile the kernel of a scene in this process, so that the workers find it in the cache."""
    schedule, period = Schedule.from_scene(scene), 1.0 / scene.numerics.frame_rate
    Twin(scene).advance(schedule.at(period), period)


def run(scene: Scene, seconds: float | None = None, progress: Callable[[float], None] | None = None) -> Run:
    """Run a scene to its end, or for `seconds`; a run that fails later returns the frames before the failure.

    Args:
        scene: The scene.
        seconds: Simulated time [s], if not that of the scene.
        progress: Called with the simulated time after every simulated second.

    Raises:
        RunError: The first frame could not be computed.
    """
    schedule, twin, infos = Schedule.from_scene(scene), Twin(scene), mark_infos(scene)
    analyzer = Analyzer(infos)
    period, duration = 1.0 / scene.numerics.frame_rate, schedule.duration if seconds is None else seconds
    count, m = max(1, round(duration / period)), len(infos)
    point, velocity, centre = (np.empty((count, m, 3)) for _ in range(3))
    spin_rate = np.empty((count, m))
    spent, told, failure = 0.0, 0.0, ""
    for k in range(count):
        time = (k + 1) * period
        try:
            frame = twin.advance(schedule.at(time), period)
        except RunError as error:
            if k == 0:
                raise
            failure, count = str(error), k
            break
        spent += frame.stats.wall_seconds
        marks = frame.marks
        point[k], velocity[k], centre[k], spin_rate[k] = marks.position, marks.velocity, marks.centre, marks.spin_rate
        analyzer.push(round(time * 1e9), marks.position, marks.spin, frame.rig.top_drive_speed, marks.wall_force)
        if progress is not None and time - told >= 1.0:
            told = time
            progress(time)
    return Run(
        np.asarray(period * np.arange(1, count + 1), float), point[:count], velocity[:count], centre[:count],
        spin_rate[:count], tuple(info.name for info in infos), analyzer.summary(), spent, failure,
    )  # fmt: skip


@dataclass(frozen=True)
class Measured:
    """Quantities of the table, from a run."""

    onset_s: float | None
    """Critical time: onset of whirl [s]."""
    frequency_hz: float | None
    """Dominant whirl after the onset [Hz], positive = forward."""
    ratio: float | None
    """Whirl frequency over rotation [-]."""
    line_hz: float | None
    """Highest line in the spectrum of mark-2 along x after the onset [Hz], as the paper reads it."""
    largest_mm: dict[str, float]
    """Largest displacement of each marked point along x or y [mm]."""
    largest_centre_mm: dict[str, float]
    """Largest displacement of the centre line at each mark [mm]."""
    motion: tuple[tuple[float, str], ...]
    """Start [s] and state of each period of motion."""
    failure: str = ""


def measure(done: Run, spectrum_of: str = "mark_2") -> Measured:
    """Quantities of the table, from a run.

    Args:
        done: The run.
        spectrum_of: Mark whose spectrum is evaluated as in the paper's section 3.2.2, if the run has it.
    """
    found = done.summary
    line = None
    if spectrum_of in done.names:
        frequency, height = x_spectrum(done, spectrum_of)
        line = float(frequency[int(np.argmax(height))]) if height.size else None
    return Measured(
        found.onset_s,
        found.mode_frequency_hz,
        found.mode_ratio,
        line,
        _largest(done.point, done.names),
        _largest(done.centre, done.names),
        tuple((period.start_s, period.state.value) for period in found.motion),
        done.failure,
    )


def x_spectrum(done: Run, mark: str) -> tuple[Array, Array]:
    """Amplitude spectrum of a mark along x after the onset: frequencies [Hz], heights [m]; shape (F,).

    With a Hann window and zeros appended; empty where less than two seconds are left.
    """
    since = done.summary.onset_s or 0.0
    x = done.point[done.time >= since, done.index(mark), 0]
    if x.size * done.period < 2.0:
        return np.empty(0), np.empty(0)
    window = np.hanning(x.size)
    height = np.abs(np.fft.rfft((x - x.mean()) * window, FINER * x.size)) * 2.0 / window.sum()
    frequency = np.asarray(np.fft.rfftfreq(FINER * x.size, done.period), float)
    return frequency, np.asarray(height, float)


def _largest(place: Array, names: tuple[str, ...]) -> dict[str, float]:
    most = np.abs(place[:, :, :2]).max(axis=(0, 2)) * 1e3
    return {name: float(value) for name, value in zip(names, most, strict=True)}


def deviation(ours: float | None, published: float) -> float | None:
    """Relative deviation from the published number [-]; None where there is no number."""
    if ours is None or not math.isfinite(ours):
        return None
    return ours / published - 1.0
