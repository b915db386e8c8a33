# SPDX-License-Identifier: Apache-2.0
"""Run of a scene at one resolution: motion of the marks and cost, with a cache on disk."""

import hashlib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self
from zipfile import BadZipFile

import numpy as np

from drill_twin.core import __version__
from drill_twin.core.arrays import Array, number_or_nan
from drill_twin.core.errors import DrillTwinError, SceneError
from drill_twin.core.files.output import whole_file
from drill_twin.dynamics.equilibrium import random_shape
from drill_twin.dynamics.solver.state import ITERATIONS
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.runs import compile_kernel
from drill_twin.runs.ensemble.parts import parts_of, planned
from drill_twin.scene import Scene, load_scene
from drill_twin.whirl import Analyzer

PERTURBATION = 1e-4
"""Size of the random velocity by which replicas of a run differ [m/s]; far below the speed of whirl."""


def require_marks(scene: Scene) -> None:
    """Check that a scene has marks, whose paths are compared.

    Raises:
        SceneError: It has none.
    """
    if not scene.string.marks:
        raise SceneError(
            f"{scene.name}: expected marks in `string.marks`, whose paths are compared, found none; add one, as "
            "`{name: middle, distance_from_bit: 4 m}`"
        )


def perturb(twin: Twin, seed: int) -> None:
    """Add a small smooth random lateral velocity, so that chaotic runs diverge."""
    _, v = twin.unknowns
    place, slope = random_shape(twin.rod.arc, np.random.default_rng(seed))
    v[:, 0:2] += PERTURBATION * place
    v[:, 3:5] += PERTURBATION * slope


FORMAT = 6
"""Version of the cache files."""
TIMED = 10
"""Frames whose processor time is measured together: of one alone the clock and the call would be a part."""


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
    """95th percentile of the processor time of a frame, as a mean of `TIMED` frames [s]."""
    iterations: Array
    """Newton iterations of each frame, shape (T,)."""
    compile_seconds: float
    """Wall-clock time to the first frame, with compiling where the kernel was not cached [s]."""
    elements: int
    step: float
    tolerance: float
    """Tolerance of Newton's method."""

    def until(self, end: float) -> Self:
        """The motion up to a time [s]; onset and frequency stay the whole run's."""
        taken = self.time <= end
        names = ("time", "centre", "contact", "hookload", "torque", "iterations")
        return replace(self, **{name: getattr(self, name)[taken] for name in names})

    @property
    def iteration_rate(self) -> float:
        """Newton iterations per simulated second [1/s]."""
        return float(self.iterations.sum() / self.time[-1])

    def save(self, path: Path) -> None:
        """Write the motion as .npz, as a whole or not at all."""
        arrays: dict[str, Any] = {name: np.asarray(value) for name, value in self.__dict__.items()}
        with whole_file(path) as stream:
            np.savez(stream, **arrays)

    @classmethod
    def load(cls, path: Path) -> Self | None:
        """Read a motion that was saved; None where there is none, or its file is cut short, as by a power cut."""
        try:
            with np.load(path, allow_pickle=False) as file:
                return cls(**{name: file[name] if file[name].ndim else file[name].item() for name in file.files})
        except (OSError, EOFError, ValueError, TypeError, BadZipFile):
            return None


def run_motion(
    scene: Scene,
    seed: int | None = None,
    *,
    until: float = math.inf,
    after_onset: float = math.inf,
    progress: Callable[[float], None] = lambda _: None,
) -> Motion:
    """Run a scene to its end, many frames at a time as a member of an ensemble.

    Args:
        scene: The scene.
        seed: Seed of a small random lateral velocity at time zero; None: start as the scene says.
        until: Simulated time at which to stop, if before the end of the scene [s].
        after_onset: Simulated time from the detection of the onset to the end [s].
        progress: Called with the simulated time [s] after some frames.

    Raises:
        RunError: A time step did not converge.
    """
    began = time.perf_counter()
    compile_kernel(scene, scene.numerics.frame_period, analysis=True)
    compiled = time.perf_counter() - began
    twin, infos = Twin(scene), mark_infos(scene)
    if seed is not None:
        perturb(twin, seed)
    analyzer, columns, now, end = Analyzer(infos), list[tuple[Array, ...]](), 0.0, math.inf
    commands, period = planned(scene, min(scene.rig.duration, until))
    for whole in parts_of(twin, commands, period, TIMED):
        spent = np.full_like(whole.rows.time, whole.seconds / whole.rows.time.size)
        count = int(np.count_nonzero(np.concatenate(([now], whole.rows.time[:-1])) < end))  # frames begun before `end`
        rows, rig, _ = whole.first(count)
        counted = rows.counted[:, ITERATIONS]
        part = (rows.time, rows.centre[..., :2], rows.string[:, 2], rig.hookload, rig.top_drive_torque, counted)
        columns.append((*(column.copy() for column in part), spent[:count]))
        after = analyzer.push_block(
            np.rint(rows.time * 1e9).astype(np.int64), rows.position, rows.spin, rig.top_drive_speed, rows.wall_force,
            rig.bit_speed,
        ).changes  # fmt: skip
        if end == math.inf and analyzer.findings.onset is not None:
            detected = min((row for row, found in after.items() if found.onset is not None), default=count - 1)
            end = after_onset + float(rows.time[detected])
        now = float(rows.time[-1])
        progress(now)
        if now >= end:
            break
    times, centre, contact, hookload, torque, iterations, spent = map(np.concatenate, zip(*columns, strict=True))
    found = analyzer.summary()
    return Motion(
        time=times, centre=centre, contact=contact, hookload=hookload, torque=torque,
        clearance=np.array([info.clearance for info in infos]),
        onset=number_or_nan(found.onset_s), frequency=number_or_nan(found.mean_frequency_hz),
        stick_slip_period=max(found.stick_slip, key=lambda one: one.cycles).period_s if found.stick_slip else math.nan,
        cost=float(spent.mean()) / period, frame_p95=float(np.quantile(spent, 0.95)), iterations=iterations,
        compile_seconds=compiled,
        elements=twin.elements, step=twin.step_size, tolerance=scene.tolerance,
    )  # fmt: skip


def cached_run(scene: str, overrides: dict[str, str], seed: int | None, folder: Path) -> Motion | str:
    """Run of a scene, read from a folder if it is there, else run and saved; the message of the error if it fails.

    The file name is a hash of the resolved scene, the seed and the version, so that an interrupted study continues and
    a changed scene is run again.
    """
    try:
        described = load_scene(scene, overrides=overrides)
        key = hashlib.sha256(f"{described.to_yaml()}{seed}{__version__}{FORMAT}".encode()).hexdigest()[:16]
        path = folder / f"{key}.npz"
        if (motion := Motion.load(path)) is None:
            motion = run_motion(described, seed)
            motion.save(path)
    except DrillTwinError as error:
        return str(error)
    return motion
