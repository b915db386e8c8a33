# SPDX-License-Identifier: Apache-2.0
"""Run of a scene with the motion of its marks, and quantities measured by the analyzer and by the paper's method."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import RunError
from drill_twin.dynamics.twin.dynamics import kernel_of
from drill_twin.dynamics.twin.frame import RigState
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.runs import compile_kernel
from drill_twin.runs.ensemble.parts import frames_of, planned
from drill_twin.runs.ensemble.run import Key, Result, on_threads
from drill_twin.scene import Scene
from drill_twin.whirl import Analyzer, Summary

TOP_SPEED = RigState._fields.index("top_drive_speed")
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


def run(scene: Scene, progress: Callable[[float], None] = lambda _: None) -> Run:
    """Run a scene to its end; a run that fails later returns the frames before the failure.

    Args:
        scene: The scene.
        progress: Called with the simulated time [s] now and then.

    Raises:
        RunError: The first frame could not be computed.
    """
    twin, infos, (commands, period) = Twin(scene), mark_infos(scene), planned(scene)
    analyzer, m, count = Analyzer(infos), len(infos), 0
    point, velocity, centre = (np.empty((len(commands), m, 3)) for _ in range(3))
    spin_rate = np.empty((len(commands), m))
    times: Array = np.asarray(period * np.arange(1, len(commands) + 1), float)
    spent, failure = 0.0, ""
    try:
        for frames in frames_of(twin, commands, period):
            at, marks = slice(count, count + frames.time.size), frames.marks
            point[at], velocity[at], centre[at] = marks.position, marks.velocity, marks.centre
            spin_rate[at] = marks.spin_rate
            stamps, speed = np.rint(times[at] * 1e9).astype(np.int64), frames.rig[:, TOP_SPEED]
            analyzer.push_block(stamps, marks.position, marks.spin, speed, marks.wall_force)
            count, spent = at.stop, spent + frames.stats.wall_seconds
            progress(twin.time)
    except RunError as error:
        if not count:
            raise
        failure = str(error)
    return Run(
        times[:count], point[:count], velocity[:count], centre[:count], spin_rate[:count],
        tuple(info.name for info in infos), analyzer.summary(), spent, failure,
    )  # fmt: skip


def runs_of(
    function: Callable[[Scene, Callable[[float], None]], Result], scenes: Mapping[Key, Scene], workers: int
) -> Generator[tuple[Key, Result]]:
    """Runs of scenes on threads, as `on_threads`; their kernels are compiled or loaded first."""
    for scene in {kernel_of(scene): scene for scene in scenes.values()}.values():
        compile_kernel(scene, scene.numerics.frame_period, analysis=True)
    yield from on_threads(function, scenes, workers)


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
        found.mean_frequency_hz,
        found.mean_ratio,
        line,
        _largest(done.point, done.names),
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
