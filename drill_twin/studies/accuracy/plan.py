# SPDX-License-Identifier: Apache-2.0
"""Choice of elements, time step and tolerance for `numerics.accuracy` from the error model, and check of the run.

The check measures the error before the onset.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drill_twin.core.arrays import Array, ComplexArray
from drill_twin.core.errors import SceneError
from drill_twin.dynamics.solver.state import ITERATIONS
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.report.recording import Recording
from drill_twin.runs import compile_kernel
from drill_twin.runs.ensemble.parts import planned
from drill_twin.scene import Scene
from drill_twin.studies.accuracy.error_model import MARGIN, ErrorModel, MeasuredPoint, load_model, save_model
from drill_twin.studies.accuracy.errors import largest_distance
from drill_twin.studies.accuracy.measure import AFTER_ONSET, Measurement, Report, at
from drill_twin.studies.accuracy.motion_run import require_marks, run_motion

PROBE = 0.2
"""Processor time that the test of this machine's speed takes [s]; less where the run does."""
PROBED = 50
"""Frames that the test computes at a time."""


@dataclass(frozen=True)
class AccuracyPlan:
    """A scene that is ready to run, with its expected error and time."""

    scene: Scene
    """With elements and step in place of `accuracy`."""
    asked: float
    """Accuracy asked for [-]."""
    expected: float
    """Expected error of the path before the onset and of the onset time [-]."""
    seconds: float
    """Expected processor time of computing the motion [s]."""
    onset_s: float | None
    """Expected onset [s]; None: no onset."""
    source: str
    """Origin of the error model: `shipped`, `cached`, or `measured` now."""
    measuring: float = 0.0
    """Processor time of the measurement of the error model, if it was measured now [s]."""
    basis: str = ""
    """The run that the error rests on, where the budget of the measurement ended it."""

    @property
    def sentence(self) -> str:
        """Message before the run."""
        numerics = self.scene.numerics
        took = f", {self.measuring:.2g} s of processor time" if self.measuring else ""
        onset = "no onset is expected" if self.onset_s is None else f"onset expected at {self.onset_s:.2f} s"
        return (
            f"accuracy {self.asked * 100:g} %: {numerics.elements} elements, {float(numerics.step) * 1e3:.3g} ms, "
            f"tolerance {self.scene.tolerance:.0e} ({self.source} curve{took}); expected: error "
            f"{self.expected * 100:.2g} %, {self.seconds:.2g} s of processor time for the motion, besides loading, "
            f"recording and check; {onset}{self.basis}"
        )


def resolve(
    scene: Scene,
    *,
    duration: float | None = None,
    progress: Report = lambda *_: None,
    compiling: Callable[[str], None] | None = None,
) -> AccuracyPlan:
    """Choose the cheapest resolution that is accurate enough.

    The formulation stays the scene's, because it changes the model and not the resolution.

    Args:
        scene: A scene with `numerics.accuracy`.
        duration: Simulated time of the run, if not the scene's [s].
        progress: Called with a line and the share done while a cost curve is measured.
        compiling: Called with the progress of a compilation, as by `compile_kernel`.

    Raises:
        SceneError: The scene has no marks, or no resolution that was tried is accurate enough.
        RunError: The finest runs fail.
    """
    asked = scene.numerics.accuracy
    if asked is None:
        raise SceneError(f'{scene.name}: expected numerics.accuracy such as "1 %", found none')
    require_marks(scene)
    length = duration or scene.rig.duration
    automatic = scene.model_copy(
        update={
            "numerics": scene.numerics.model_copy(update={"accuracy": None}),
            "rig": scene.rig.model_copy(update={"duration": length}),
        }
    )
    compile_kernel(automatic, scene.numerics.frame_period, compiling, analysis=True)
    began, measuring = time.thread_time(), 0.0
    model, source = load_model(scene) or (None, "")
    if model is None or not model.covers(length) or (model.cheapest(asked) is None and model.ended != "finest"):
        model, source = Measurement(automatic, asked, progress).model(), "measured"
        save_model(model)
        measuring = time.thread_time() - began
    point = model.cheapest(asked)
    if point is None:
        raise SceneError(_refusal(scene, asked, model))
    chosen = at(scene, point.elements, point.step, point.tolerance)
    seconds = expected_seconds(chosen, model.iterations(point, length), length)
    return AccuracyPlan(chosen, asked, model.expected(point), seconds, model.onset_s, source, measuring, _basis(model))


def _basis(model: ErrorModel) -> str:
    if model.ended != "budget":
        return ""
    return (
        f". The measurement ended with its budget of time: the error rests on a run of {model.elements} elements and "
        f"{model.step * 1e3:.3g} ms, and coarser resolutions may do"
    )


def _refusal(scene: Scene, asked: float, model: ErrorModel) -> str:
    best: MeasuredPoint = min(model.judged or model.points, key=model.expected)
    why = "when its budget of time ended" if model.ended == "budget" else "with what was tried"
    return (
        f"{scene.name}: numerics.accuracy: expected an error that can be reached, found {asked * 100:.2g} %, and at "
        f"best {MARGIN * model.expected(best) * 100:.2g} % {why}, by {best.elements} elements and "
        f"{best.step * 1e3:.3g} ms against {model.elements} and {model.step * 1e3:.3g} ms; ask for less, or see "
        f"drill-twin cost {scene.name} and give numerics.elements and numerics.step"
    )


def expected_seconds(scene: Scene, iterations: float, duration: float) -> float:
    """Processor time of computing the motion of a run on this machine now [s].

    The beginning of the run is computed, in turn without and with what a recorded run keeps of each frame. The first
    gives the time of a Newton iteration, the second the time of a frame besides.

    Args:
        scene: The scene at the resolution of the run.
        iterations: Newton iterations of the run.
        duration: Its simulated time [s].
    """
    twin, (commands, period) = Twin(scene), planned(scene, duration)
    twin.load()
    rows, record = twin.record(PROBED, nodes=False), twin.record(PROBED)
    plain, recorded = np.zeros(3), np.zeros(3)  # processor time [s], Newton iterations, blocks of frames
    began = time.thread_time()
    for first in range(0, len(commands) - 2 * PROBED, 2 * PROBED):
        busy = time.thread_time()
        twin.advance_frames(commands[first : first + PROBED], period, rows)
        plain += time.thread_time() - busy, rows.frames.counted[:, ITERATIONS].sum(), 1.0
        busy = time.thread_time()
        frames, error = twin.fill(record, commands[first + PROBED : first + 2 * PROBED], period)
        recorded += time.thread_time() - busy, frames.stats.iterations, 1.0
        if error is not None:
            raise error
        if time.thread_time() - began > PROBE:
            break
    of_iteration = plain[0] / max(plain[1], 1.0)
    of_frame = max(0.0, recorded[0] - of_iteration * recorded[1]) / max(recorded[2] * PROBED, 1.0)
    return float(of_iteration * iterations + of_frame * len(commands))


RICHARDSON = 4.0 / 3.0
"""Error over the difference from a run of half the step and twice the elements, for second order."""
METHOD = (
    "part before the onset rerun with twice the elements, half the step and a tenth of the tolerance: largest distance "
    "of the marks' paths over the largest deflection, and difference of the onset times, each times 4/3"
)


@dataclass(frozen=True)
class AccuracyResult:
    """Error and time of a run: asked for, expected and actual."""

    asked: float
    expected: float
    actual: float | None
    """Measured error [-]; None where it was not checked."""
    how: str
    """Method by which `actual` was measured."""
    expected_seconds: float
    """Expected processor time of computing the motion, without loading, recording and this check [s]."""
    actual_seconds: float
    """Actual one [s]."""
    measuring_seconds: float
    """Processor time of the measurement of the error model; 0 where there was one [s]."""
    check_seconds: float
    """Processor time of this check [s]."""


def check(
    plan: AccuracyPlan,
    recording: Recording,
    motion_seconds: float,
    *,
    rerun: bool = True,
    progress: Callable[[float], None] = lambda _: None,
) -> AccuracyResult:
    """Compare a finished run with its plan.

    Args:
        plan: The plan of the run.
        recording: The run.
        motion_seconds: Processor time of computing its motion [s].
        rerun: Run the part before the onset again with twice the elements and half the step; else `actual` is None.
        progress: Called with the simulated time of the rerun [s].

    Raises:
        RunError: The finer run fails.
    """
    began, onset = time.thread_time(), recording.summary.onset_s
    return AccuracyResult(
        asked=plan.asked,
        expected=plan.expected,
        actual=_actual(plan, recording.marks.time, recording.centre_lines(), onset, progress) if rerun else None,
        how=METHOD if rerun else "not checked",
        expected_seconds=plan.seconds,
        actual_seconds=motion_seconds,
        measuring_seconds=plan.measuring,
        check_seconds=time.thread_time() - began,
    )


def _actual(
    plan: AccuracyPlan, time: Array, line: ComplexArray, onset: float | None, progress: Callable[[float], None]
) -> float:
    numerics = plan.scene.numerics
    finer = at(plan.scene, 2 * int(numerics.elements), 0.5 * float(numerics.step), 0.1 * plan.scene.tolerance)
    motion = run_motion(finer, after_onset=AFTER_ONSET, progress=progress)
    common = min(time.size, motion.time.size)
    true = motion.centre[:common, :, 0] + 1j * motion.centre[:common, :, 1]
    early = time[:common] <= min(motion.onset if math.isfinite(motion.onset) else math.inf, time[-1])
    path = largest_distance(line[:common][early], true[early])
    if onset is None or not math.isfinite(motion.onset):
        return RICHARDSON * path if (onset is None) == (not math.isfinite(motion.onset)) else 1.0
    return RICHARDSON * max(path, abs(onset - motion.onset) / motion.onset)
