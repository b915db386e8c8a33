# SPDX-License-Identifier: Apache-2.0
"""Run of a scene at one resolution: motion of the marks and cost, with a cache on disk."""

from __future__ import annotations

import hashlib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from drill_twin import __version__
from drill_twin.accuracy.trial import perturb
from drill_twin.base.arrays import Array
from drill_twin.base.missing import number_or_nan
from drill_twin.errors import DrillTwinError
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.scene import Scene, load_scene
from drill_twin.schedule import Schedule
from drill_twin.twin.twin import Twin
from drill_twin.whirl import Analyzer

FORMAT = 4
"""Version of the cache files."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion and cost of a run; T frames, m marks."""

    time: Array
    """Times of the frames [s], shape (T,)."""
    centre: Array
    """Lateral position of the centre line at the marks [m], shape (T, m, 2)."""
    contact: Array
    """Share of nodes at the wall [-], shape (T,)."""
    hookload: Array
    """Hookload [N], shape (T,)."""
    torque: Array
    """Torque of the top drive [N m], shape (T,)."""
    clearance: Array
    """Clearance at the marks [m], shape (m,)."""
    onset: float
    """Onset of whirl [s]; nan if there was none."""
    frequency: float
    """Dominant whirl after it, positive = forward [Hz]; nan if there was none."""
    stick_slip_period: float
    """Mean cycle of the longest period of stick-slip [s]; nan if there was none."""
    cost: float
    """Processor time of the physics per simulated second [s/s]."""
    frame_p95: float
    """95th percentile of the processor time of a frame [s]."""
    spent: Array
    """Processor time of the physics in each frame [s], shape (T,)."""
    compile_seconds: float
    """Wall-clock time to the first frame, with compiling where the kernel was not cached [s]."""
    iterations: float
    """Newton iterations per simulated second [1/s]."""
    elements: int
    step: float
    tolerance: float
    """Tolerance of Newton's method."""

    def until(self, end: float) -> Motion:
        """The motion up to a time [s]; onset and frequency are those of the whole run."""
        taken = self.time <= end
        cut = {
            name: getattr(self, name)[taken] for name in ("time", "centre", "contact", "hookload", "torque", "spent")
        }
        return replace(self, **cut)

    def save(self, path: Path) -> None:
        """Write the motion as .npz, then rename the file, so that no reader finds half of it."""
        part = path.with_suffix(".part.npz")
        arrays: dict[str, Any] = {name: np.asarray(value) for name, value in self.__dict__.items()}
        np.savez(part, **arrays)
        part.replace(path)

    @staticmethod
    def load(path: Path) -> Motion:
        """Read a motion that was saved."""
        with np.load(path, allow_pickle=False) as file:
            plain = {name: file[name] if file[name].ndim else file[name].item() for name in file.files}
        return Motion(**plain)


def run_motion(
    scene: Scene,
    seed: int | None = None,
    *,
    until: float = math.inf,
    after_onset: float = math.inf,
    progress: Callable[[float], None] = lambda _: None,
) -> Motion:
    """Run a scene to its end.

    Args:
        scene: The scene.
        seed: Seed of a small random lateral velocity at time zero; None: start as the scene says.
        until: Simulated time at which to stop, if before the end of the scene [s].
        after_onset: Simulated time from the detection of the onset to the end [s].
        progress: Called with the simulated time [s] after every frame.

    Raises:
        RunError: A time step did not converge.
    """
    schedule = Schedule.from_scene(scene)
    period = 1.0 / scene.numerics.frame_rate
    began = time.perf_counter()
    Twin(scene).advance(schedule.at(period), period)
    compiled = time.perf_counter() - began
    twin = Twin(scene)
    if seed is not None:
        perturb(twin, seed)
    infos = mark_infos(scene)
    analyzer = Analyzer(infos)
    frames = max(1, round(min(schedule.duration, until) / period))
    times, spent, contact, hookload, torque = (np.zeros(frames) for _ in range(5))
    centre = np.empty((frames, len(infos), 2))
    iterations, k, found_at = 0, 0, math.inf
    while k < frames and times[k - 1] < found_at + after_onset:
        command = schedule.at((k + 1) * period)
        began = time.process_time()
        frame = twin.advance(command, period)
        spent[k] = time.process_time() - began
        times[k], centre[k] = frame.time, frame.marks.centre[:, :2]
        contact[k] = np.mean(frame.wall_force > 0.0)
        iterations += frame.stats.iterations
        marks, rig = frame.marks, frame.rig
        hookload[k], torque[k] = rig.hookload, rig.top_drive_torque
        live = analyzer.push(
            round(frame.time * 1e9), marks.position, marks.spin, rig.top_drive_speed, marks.wall_force, rig.bit_speed
        )
        if live.onset is not None:
            found_at = min(found_at, frame.time)
        progress(frame.time)
        k += 1
    taken = slice(0, k)
    found = analyzer.summary()
    return Motion(
        time=times[taken],
        centre=centre[taken],
        contact=contact[taken],
        hookload=hookload[taken],
        torque=torque[taken],
        clearance=np.array([info.clearance for info in infos]),
        onset=number_or_nan(found.onset_s),
        frequency=number_or_nan(found.mode_frequency_hz),
        stick_slip_period=max(found.stick_slip, key=lambda one: one.cycles).period_s if found.stick_slip else np.nan,
        cost=float(spent.sum()) / (k * period),
        frame_p95=float(np.quantile(spent[taken], 0.95)),
        spent=spent[taken],
        compile_seconds=compiled,
        iterations=iterations / (k * period),
        elements=twin.elements,
        step=twin.step_size,
        tolerance=scene.tolerance,
    )


def cached_run(scene: str, overrides: dict[str, str], seed: int | None, folder: Path) -> Motion | str:
    """Run of a scene, read from a folder if it is there, else run and saved; the message of the error if it fails.

    The file name is a hash of the resolved scene, the seed and the version, so that an interrupted study continues and
    a changed scene is run again.
    """
    try:
        described = load_scene(scene, overrides=overrides)
        key = hashlib.sha256(f"{described.to_yaml()}{seed}{__version__}{FORMAT}".encode()).hexdigest()[:16]
        path = folder / f"{key}.npz"
        if (cached := _undamaged(path)) is not None:
            return cached
        motion = run_motion(described, seed)
        motion.save(path)
    except DrillTwinError as error:
        return str(error)
    return motion


def _undamaged(path: Path) -> Motion | None:
    """A cached run; None where there is none, or where its file is cut short, as by a power cut."""
    try:
        return Motion.load(path)
    except (OSError, EOFError, ValueError, TypeError, BadZipFile):
        return None
