# SPDX-License-Identifier: Apache-2.0
"""Choice of elements, time step and tolerance for `numerics.accuracy`, from the error model of the scene."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from drill_twin.accuracy.error_model import MARGIN, ErrorModel, Point, from_motions, load_model, save_model
from drill_twin.accuracy.motion_run import Motion, run_motion
from drill_twin.errors import RunError, SceneError
from drill_twin.scene import Scene
from drill_twin.twin.twin import Twin

ELEMENTS = (0.5, 1.0, 2.0)
"""Elements of a small cost curve over those that `auto` chooses."""
STEPS = (4.0, 2.0, 1.0, 0.5)
"""Time steps of a small cost curve over the one that `auto` chooses; none is longer than a frame."""
FINER = 2.0
"""Elements of the converged run over the most, and the shortest step over its step."""
MIN_ELEMENTS = 4
LOOSE, TIGHT = 1e-4, 0.01
"""Newton's tolerance of a small cost curve, and of the converged run over it."""
REFINEMENTS = 2
"""Number of refinements by two where no resolution is accurate enough."""
AFTER_ONSET = 2.0
"""Simulated time after the onset at which runs of a small cost curve end [s]."""
PROBE = 1.0
"""Simulated time of the run that measures the speed of this machine [s]."""


@dataclass(frozen=True)
class Plan:
    """A scene that is ready to run, with its expected error and time."""

    scene: Scene
    """With elements and step in place of `accuracy`."""
    asked: float
    """Accuracy asked for [-]."""
    expected: float
    """Expected error of the path before the onset and of the onset time [-]."""
    seconds: float
    """Expected processor time of the run [s]."""
    onset_s: float | None
    """Expected onset [s]; None: no onset."""
    source: str
    """Origin of the error model: `shipped`, `cached`, or `measured` now."""

    @property
    def sentence(self) -> str:
        """Message before the run."""
        numerics = self.scene.numerics
        onset = "no onset is expected" if self.onset_s is None else f"onset expected at {self.onset_s:.2f} s"
        return (
            f"accuracy {self.asked * 100:g} %: {numerics.elements} elements, {float(numerics.step) * 1e3:.3g} ms, "
            f"tolerance {self.scene.tolerance:.0e} ({self.source} curve); error {self.expected * 100:.2g} % and "
            f"{self.seconds:.2g} s of a core expected, {onset}"
        )


def resolve(
    scene: Scene, *, duration: float | None = None, progress: Callable[[str, float], None] = lambda *_: None
) -> Plan:
    """Choose the cheapest resolution that is accurate enough.

    The formulation stays the scene's, because it changes the model and not the resolution.

    Args:
        scene: A scene with `numerics.accuracy`.
        duration: Simulated time of the run, if not the scene's [s].
        progress: Called with a line and the share done while a cost curve is measured.

    Raises:
        SceneError: The scene has no marks, or no resolution that was tried is accurate enough.
        RunError: The converged run fails.
    """
    asked = scene.numerics.accuracy
    if asked is None:
        raise SceneError(f'{scene.name}: expected numerics.accuracy such as "1 %", found none')
    if not scene.string.marks:
        raise SceneError(
            f"{scene.name}: numerics.accuracy: expected marks in string.marks, whose paths it controls, found none; "
            "give numerics.elements and numerics.step instead"
        )
    found = load_model(scene)
    model, source = found or (None, "measured")
    finer = 1.0
    for _ in range(REFINEMENTS + 1):
        if model is not None and (point := model.cheapest(asked)) is not None:
            return _plan(scene, asked, model, point, source, duration or scene.rig.duration)
        model, source = measure_error_model(scene, finer, progress), "measured"
        save_model(model)
        finer *= 2.0
    best = 0.0 if model is None else MARGIN * model.expected(min(model.points, key=model.expected))
    raise SceneError(
        f"{scene.name}: numerics.accuracy: expected an error that can be reached, found {asked * 100:.2g} %, and at "
        f"best {best * 100:.2g} % with what was tried; ask for less, or see drill-twin cost {scene.name} and give "
        "numerics.elements and numerics.step"
    )


def _plan(scene: Scene, asked: float, model: ErrorModel, point: Point, source: str, duration: float) -> Plan:
    chosen = at(scene, point.elements, point.step, point.tolerance)
    faster = run_motion(chosen, until=PROBE).cost / _probe_cost(model, point)
    return Plan(chosen, asked, model.expected(point), faster * model.seconds(point, duration), model.onset_s, source)


def _probe_cost(model: ErrorModel, point: Point) -> float:
    return model.seconds(point, PROBE) / PROBE


def at(scene: Scene, elements: int, step: float, tolerance: float) -> Scene:
    """The scene at a resolution: elements, time step [s], tolerance of Newton's method."""
    chosen = {"accuracy": None, "elements": elements, "step": step, "tolerance": tolerance}
    return scene.model_copy(update={"numerics": scene.numerics.model_copy(update=chosen)})


def measure_error_model(
    scene: Scene, finer: float = 1.0, progress: Callable[[str, float], None] = lambda *_: None
) -> ErrorModel:
    """Error model from a small cost curve: a dozen resolutions up to shortly after the onset, and a converged run.

    Args:
        scene: The scene.
        finer: Factor of refinement.
        progress: Called with a line and the share done.

    Raises:
        RunError: The converged run fails.
    """
    automatic = Twin(scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"accuracy": None})}))
    frame = 1.0 / scene.numerics.frame_rate
    counts = sorted({max(MIN_ELEMENTS, round(share * finer * automatic.elements)) for share in ELEMENTS})
    steps = sorted({min(share / finer * automatic.step_size, frame) for share in STEPS}, reverse=True)
    exact = (round(FINER * counts[-1]), steps[-1] / FINER)
    resolutions = [(count, step) for count in counts for step in steps]
    loose = LOOSE / finer**2
    work = [count / step for count, step in (exact, *resolutions)]
    total, done, end = sum(work), 0.0, scene.rig.duration

    def run(
        count: int, step: float, tolerance: float, *, until: float = math.inf, after_onset: float = math.inf
    ) -> Motion:
        nonlocal done
        share, began = count / step / total, done

        def report(time: float) -> None:
            progress(f"{count} elements, {step * 1e3:.3g} ms", min(began + share * min(time / end, 1.0), 1.0))

        motion = run_motion(at(scene, count, step, tolerance), progress=report, until=until, after_onset=after_onset)
        done += share
        return motion

    reference = run(*exact, TIGHT * loose, after_onset=AFTER_ONSET)
    end = float(reference.time[-1])
    motions, later = [], 1.0
    for number, resolution in enumerate(resolutions):
        try:
            # the coarsest runs to the end of the scene, which shows how the cost changes after the onset
            motion = run(*resolution, loose, until=math.inf if number == 0 else end)
        except RunError:
            continue  # too coarse to converge: no resolution to choose
        motions.append(motion.until(end))
        if number == 0 and motion.time.size > motions[0].time.size:
            later = _late_cost(motion, reference)
    if not motions:
        raise RunError(
            f"{scene.name}: none of {len(resolutions)} resolutions could be run; see drill-twin cost {scene.name}"
        )
    return from_motions(scene, reference, motions, later)


def _late_cost(motion: Motion, reference: Motion) -> float:
    """Cost after the onset over the cost of that part of it which the other runs cover."""
    after = motion.time > reference.onset
    shown = after & (motion.time <= reference.time[-1])
    return float(motion.spent[after].mean() / motion.spent[shown].mean()) if shown.any() else 1.0
