# SPDX-License-Identifier: Apache-2.0
"""Run of a scene with the motion of its marks, and quantities measured by the analyzer and by the paper's method."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.ensemble.outputs import Collector, Request, Variable
from drill_twin.ensemble.run import Run as Member
from drill_twin.ensemble.run import frames_of, run_scene
from drill_twin.errors import RunError
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.scene import Scene
from drill_twin.twin.frame import Frames, RigState
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


class Motion(Collector):
    """The motion of a run, with the summary of the analyzer."""

    whole = True

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        infos = mark_infos(twin.scene)
        self._names, self._analyzer = tuple(info.name for info in infos), Analyzer(infos)
        self._time: Array = np.asarray(request.period * np.arange(1, request.frames + 1), float)
        self._marks: list[Array] = [np.empty((request.frames, len(infos), 3)[:axes]) for axes in (3, 3, 3, 2)]
        self._count, self._spent = 0, 0.0

    def add_frames(self, frames: Frames) -> None:
        """Add frames."""
        marks, count = frames.marks, frames.time.size
        at = slice(self._count, self._count + count)
        for array, part in zip(
            self._marks, (marks.position, marks.velocity, marks.centre, marks.spin_rate), strict=True
        ):
            array[at] = part
        stamps = np.rint(self._time[at] * 1e9).astype(np.int64)
        speed = frames.rig[:, RigState._fields.index("top_drive_speed")]
        self._analyzer.push_block(stamps, marks.position, marks.spin, speed, marks.wall_force)
        self._count, self._spent = at.stop, self._spent + frames.stats.wall_seconds

    def close(self) -> Mapping[str, Variable]:
        """The run up to its last frame."""
        time, point, velocity, centre, spin_rate = (array[: self._count] for array in (self._time, *self._marks))
        run = Run(
            time, point, velocity, centre, spin_rate, self._names, self._analyzer.summary(), self._spent
        )  # fmt: skip
        return {"run": Variable(run, (), "")}


def run(scene: Scene, seconds: float | None = None) -> Run:
    """Run a scene to its end, or for `seconds`; a run that fails later returns the frames before the failure.

    Args:
        scene: The scene.
        seconds: Simulated time [s], if not that of the scene.

    Raises:
        RunError: The first frame could not be computed.
    """
    return run_of(run_scene(scene, [Motion], *frames_of(scene, seconds)))


def run_of(member: Member) -> Run:
    """The run of a member with the output `Motion`.

    Raises:
        RunError: Its first frame could not be computed.
    """
    if not member.values:
        raise RunError(member.failure)
    done: Run = member.values["run"].value
    return replace(done, failure=member.failure)


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
