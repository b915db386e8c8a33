# SPDX-License-Identifier: Apache-2.0
"""From `accuracy` to elements and step: the curve of the scene, measured where there is none."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from drill_twin.accuracy.error_model import MARGIN, Point, Promise, from_motions, keep, kept
from drill_twin.accuracy.motion_run import Motion, run_motion
from drill_twin.errors import RunError, SceneError
from drill_twin.scene import Scene
from drill_twin.twin.twin import Twin

ELEMENTS = (0.5, 1.0, 2.0)
"""Elements of a small curve over those that `auto` chooses."""
STEPS = (4.0, 2.0, 1.0, 0.5)
"""Steps of a small curve over that which `auto` chooses; none is longer than a frame."""
FINER = 2.0
"""The converged run's elements over the most, and the shortest step over its step."""
FEWEST = 4
LOOSE, TIGHT = 1e-4, 0.01
"""Newton's tolerance of a small curve, and of the converged run over that."""
REFINEMENTS = 2
"""How often all is made twice as fine where nothing is accurate enough."""
AFTER = 2.0
"""Simulated time that runs of a small curve go on after the onset was found [s]."""
PROBE = 1.0
"""Simulated time of the run that tells how fast this machine is [s]."""


@dataclass(frozen=True)
class Plan:
    """A scene that is ready to run, and what to expect of it."""

    scene: Scene
    """With elements and step in place of `accuracy`."""
    asked: float
    """[-]"""
    expected: float
    """Error to expect of the path before the onset and of the onset time [-]."""
    seconds: float
    """Processor time of the run to expect [s]."""
    onset_s: float | None
    """Onset to expect [s]."""
    source: str
    """Where the curve comes from: `shipped`, `cached`, or `measured` now."""

    @property
    def sentence(self) -> str:
        """What to say before the run."""
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

    The form of the string stays the scene's: it decides what is computed, not how well.

    Args:
        scene: A scene with `numerics.accuracy`.
        duration: Simulated time of the run, if not the scene's [s].
        progress: Called with a line and the share done while a curve is measured.

    Raises:
        SceneError: The scene has no marks, or nothing that was tried is accurate enough.
        RunError: The converged run fails.
    """
    asked = scene.numerics.accuracy
    if asked is None:
        raise SceneError(f'{scene.name}: expected numerics.accuracy such as "1 %", found none')
    if not scene.string.marks:
        raise SceneError(
            f"{scene.name}: numerics.accuracy: expected marks in string.marks, whose paths it promises, found none; "
            "give numerics.elements and numerics.step instead"
        )
    found = kept(scene)
    promise, source = found or (None, "measured")
    finer = 1.0
    for _ in range(REFINEMENTS + 1):
        if promise is not None and (point := promise.cheapest(asked)) is not None:
            return _plan(scene, asked, promise, point, source, duration or scene.rig.duration)
        promise, source = measure(scene, finer, progress), "measured"
        keep(promise)
        finer *= 2.0
    best = 0.0 if promise is None else MARGIN * promise.expected(min(promise.points, key=promise.expected))
    raise SceneError(
        f"{scene.name}: numerics.accuracy: expected an error that can be promised, found {asked * 100:.2g} %, and at "
        f"best {best * 100:.2g} % with what was tried; ask for less, or see drill-twin cost {scene.name} and give "
        "numerics.elements and numerics.step"
    )


def _plan(scene: Scene, asked: float, promise: Promise, point: Point, source: str, duration: float) -> Plan:
    chosen = at(scene, point.elements, point.step, point.tolerance)
    faster = run_motion(chosen, until=PROBE).cost / _cost_of_the_probe(promise, point)
    return Plan(
        chosen, asked, promise.expected(point), faster * promise.seconds(point, duration), promise.onset_s, source
    )


def _cost_of_the_probe(promise: Promise, point: Point) -> float:
    return promise.seconds(point, PROBE) / PROBE


def at(scene: Scene, elements: int, step: float, tolerance: float) -> Scene:
    """The scene at a resolution: elements, step [s], tolerance of Newton's method."""
    chosen = {"accuracy": None, "elements": elements, "step": step, "tolerance": tolerance}
    return scene.model_copy(update={"numerics": scene.numerics.model_copy(update=chosen)})


def measure(scene: Scene, finer: float = 1.0, progress: Callable[[str, float], None] = lambda *_: None) -> Promise:
    """A small curve: a dozen resolutions up to shortly after the onset, against a converged run.

    Args:
        scene: The scene.
        finer: How many times finer than usual.
        progress: Called with a line and the share done.

    Raises:
        RunError: The converged run fails.
    """
    automatic = Twin(scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"accuracy": None})}))
    frame = 1.0 / scene.numerics.frame_rate
    counts = sorted({max(FEWEST, round(share * finer * automatic.elements)) for share in ELEMENTS})
    steps = sorted({min(share / finer * automatic.step_size, frame) for share in STEPS}, reverse=True)
    exact = (round(FINER * counts[-1]), steps[-1] / FINER)
    rungs = [(count, step) for count in counts for step in steps]
    loose = LOOSE / finer**2
    work = [count / step for count, step in (exact, *rungs)]
    total, done, end = sum(work), 0.0, scene.rig.duration

    def run(
        count: int, step: float, tolerance: float, *, until: float = math.inf, after_onset: float = math.inf
    ) -> Motion:
        nonlocal done
        share, began = count / step / total, done

        def tell(time: float) -> None:
            progress(f"{count} elements, {step * 1e3:.3g} ms", min(began + share * min(time / end, 1.0), 1.0))

        motion = run_motion(at(scene, count, step, tolerance), progress=tell, until=until, after_onset=after_onset)
        done += share
        return motion

    reference = run(*exact, TIGHT * loose, after_onset=AFTER)
    end = float(reference.time[-1])
    motions, later = [], 1.0
    for number, rung in enumerate(rungs):
        try:
            # the coarsest goes on to the end of the scene: it tells how the cost will change
            motion = run(*rung, loose, until=math.inf if number == 0 else end)
        except RunError:
            continue  # too coarse to be followed: no resolution to choose
        motions.append(motion.until(end))
        if number == 0 and motion.time.size > motions[0].time.size:
            later = _later(motion, reference)
    if not motions:
        raise RunError(f"{scene.name}: none of {len(rungs)} resolutions could be run; see drill-twin cost {scene.name}")
    return from_motions(scene, reference, motions, later)


def _later(motion: Motion, reference: Motion) -> float:
    """Cost of all that follows the onset over the cost of what of it the other runs show."""
    after = motion.time > reference.onset
    shown = after & (motion.time <= reference.time[-1])
    return float(motion.spent[after].mean() / motion.spent[shown].mean()) if shown.any() else 1.0
