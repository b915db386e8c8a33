# SPDX-License-Identifier: Apache-2.0
"""Cost curve of a scene: error and time of runs at many resolutions."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from drill_twin.core import __version__
from drill_twin.core.errors import RunError, SceneError
from drill_twin.dynamics.discretisation.kernel_arguments import JOINED, LATERAL, SPATIAL, form_of
from drill_twin.dynamics.discretisation.resolution import resolution_of
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene, load_scene
from drill_twin.scene.blocks.numerics import FEWEST_ELEMENTS
from drill_twin.studies.accuracy.errors import MotionErrors, compare, spread
from drill_twin.studies.accuracy.motion_run import Motion, cached_run
from drill_twin.studies.pool import run_jobs

ELEMENTS = (0.375, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
"""Elements over the number that `auto` chooses."""
STEPS = (2.0, 1.0, 0.5, 0.25, 0.125)
"""Time steps over the step that `auto` chooses; no step is longer than a frame."""
TOLERANCES = (1e-3, 1e-4, 1e-6)
"""Tolerances of Newton's method to try besides the scene's own, at the resolution that `auto` chooses."""
FINER = 2.0
"""Elements of the converged run over the elements of the finest resolution; its time step is as much shorter."""


@dataclass(frozen=True)
class Resolution:
    """Formulation, mesh, time step and tolerance of a run."""

    form: str
    elements: int
    step: float
    tolerance: float | None = None
    """Tolerance of Newton's method; None: the scene's tolerance."""

    @property
    def text(self) -> str:
        """The resolution as one line of text."""
        tolerance = "" if self.tolerance is None else f", tolerance {self.tolerance:.0e}"
        return f"{self.form}, {self.elements} elements, {self.step * 1e3:.3g} ms{tolerance}"

    def overrides(self) -> dict[str, str]:
        """Overrides of a scene that set this resolution."""
        numerics = {
            "numerics.accuracy": "null", "numerics.elements": str(self.elements), "numerics.step": f"{self.step!r} s",
        }  # fmt: skip
        off = {"effects.stretch": "off", "effects.torsion": "off"} if self.form == LATERAL else {}
        off |= {"numerics.lateral_from": "0 m"} if self.form == SPATIAL else {}
        own = {} if self.tolerance is None else {"numerics.tolerance": repr(self.tolerance)}
        return numerics | off | own


@dataclass(frozen=True)
class MeasuredRun:
    """Errors and cost of a run."""

    resolution: Resolution
    errors: MotionErrors
    cost: float
    """Processor time per simulated second [s/s]."""
    realtime_factor: float
    frame_p95: float
    """95th percentile of the processor time of a frame [s]."""
    compile_seconds: float
    iterations: float
    """Newton iterations per simulated second [1/s]."""
    on_front: bool = False
    """True if no other run is both cheaper and more accurate in the errors that `accuracy` controls."""


@dataclass(frozen=True)
class Curve:
    """The cost curve of one scene."""

    scene: str
    version: str
    reference: Resolution
    noise: MotionErrors
    """Spread of replicas of the converged run: smaller errors cannot be resolved."""
    onset_s: float | None
    """Onset of the converged run [s]."""
    runs: tuple[MeasuredRun, ...]
    failures: tuple[str, ...] = ()
    """Resolutions that could not be run, and why."""

    @property
    def whole(self) -> MeasuredRun | None:
        """The run of the whole string beside runs with lateral motion from a depth down (`numerics.lateral_from`)."""
        others = (run for run in self.runs if self.reference.form == JOINED and run.resolution.form == SPATIAL)
        return next(others, None)

    @property
    def front(self) -> list[MeasuredRun]:
        """Runs on the Pareto front, cheapest first."""
        return sorted((run for run in self.runs if run.on_front), key=lambda run: run.cost)


def choose_resolutions(
    scene: Scene, elements: tuple[float, ...] = ELEMENTS, steps: tuple[float, ...] = STEPS
) -> list[Resolution]:
    """Multiples of the resolution that `auto` chooses, for each formulation that the scene permits (`forms`)."""
    numerics = scene.numerics.model_copy(update={"elements": "auto", "step": "auto", "accuracy": None})
    automatic, sections = scene.model_copy(update={"numerics": numerics}), len(scene.string.sections)
    twin = Twin(automatic)
    counts = sorted({max(FEWEST_ELEMENTS, sections, round(share * twin.elements)) for share in elements})
    frame = scene.numerics.frame_period
    lengths = sorted({min(share * twin.step_size, frame) for share in steps}, reverse=True)
    resolutions = [Resolution(form, count, length) for form in forms(scene) for count in counts for length in lengths]
    plain = (resolutions[0].form, max(FEWEST_ELEMENTS, sections, twin.elements), min(twin.step_size, frame))
    return resolutions + [Resolution(*plain, tolerance) for tolerance in TOLERANCES] + whole_string(automatic)


def on_meshes(scene: Scene, elements: Sequence[int]) -> list[Resolution]:
    """Resolutions with numbers of elements, in the scene's own formulation, at its step.

    Raises:
        SceneError: A scene that asks for an accuracy.
    """
    form, step = forms(scene)[0], resolution_of(scene)[1]
    return [Resolution(form, count, step) for count in elements] + whole_string(scene)


def whole_string(scene: Scene) -> list[Resolution]:
    """The whole string with elements of `auto`, at the step of a scene with a joint, which it prices; else none."""
    numerics = scene.numerics.model_copy(update={"lateral_from": 0.0, "elements": "auto"})
    whole = scene.model_copy(update={"numerics": numerics})
    return [Resolution(SPATIAL, *resolution_of(whole))] if form_of(scene) == JOINED else []


def forms(scene: Scene) -> list[str]:
    """The scene's own formulation, and the lateral one too if none of its effects needs stretch, torsion or a joint."""
    if (form := form_of(scene)) != SPATIAL:
        return [form]
    needing = [key for key, block in scene.effects.blocks.items() if {"stretch", "torsion"} & set(block.requires)]
    return [SPATIAL] if needing else [SPATIAL, LATERAL]


def converged(resolutions: list[Resolution]) -> Resolution:
    """Resolution of the reference run: the first formulation, finer than the finest resolution."""
    return Resolution(
        resolutions[0].form,
        round(FINER * max(one.elements for one in resolutions if one.form == resolutions[0].form)),
        min(resolution.step for resolution in resolutions) / FINER,
    )


def measure(
    scene: str,
    overrides: Mapping[str, str],
    resolutions: list[Resolution],
    folder: Path,
    *,
    replicas: int = 3,
    workers: int = 2,
    progress: Callable[[str], None] = lambda _: None,
) -> Curve:
    """Run a scene at every resolution and compare with the converged run.

    Args:
        scene: Name or file of the scene.
        overrides: Changes to it.
        resolutions: Resolutions to run; see `choose_resolutions`.
        folder: Cache of runs, so that an interrupted study continues.
        replicas: Replicas of the converged run, for the uncertainty of its statistics.
        workers: Processes; fewer than cores give cleaner times.
        progress: Called with a line as each run ends.

    Raises:
        SceneError: The scene is invalid, or could not be run at any resolution.
        RunError: The converged run fails.
    """
    described = load_scene(scene, overrides=dict(overrides))
    exact = converged(resolutions)
    keys: list[tuple[Resolution, int | None]] = [(exact, None), *((exact, seed) for seed in range(replicas))]
    keys += [(resolution, None) for resolution in resolutions]
    jobs = {
        (resolution, seed): (scene, {**overrides, **resolution.overrides()}, seed, folder) for resolution, seed in keys
    }
    done = run_jobs(cached_run, jobs, workers, done=lambda key, _: progress(key[0].text))
    if isinstance(reference := done[exact, None], str):
        raise RunError(f"the converged run of {described.name} failed: {reference}")
    others = [motion for seed in range(replicas) if isinstance(motion := done[exact, seed], Motion)]
    measured, failures = [], []
    for resolution in resolutions:
        if isinstance(motion := done[resolution, None], str):
            failures.append(f"{resolution.text}: {motion}")
        else:
            costs = motion.cost, 1.0 / motion.cost, motion.frame_p95, motion.compile_seconds, motion.iteration_rate
            measured.append(MeasuredRun(resolution, compare(motion, reference), *costs))
    if not measured:
        raise SceneError(f"none of the resolutions of {described.name} ran; the first: {failures[0]}")
    own = [run for run in measured if exact.form != JOINED or run.resolution.form == JOINED]
    front = pareto_front(own, lambda run: run.errors.controlled)
    return Curve(
        scene=described.name,
        version=__version__,
        reference=exact,
        noise=spread(others, reference),
        onset_s=None if reference.onset != reference.onset else reference.onset,
        runs=tuple(replace(run, on_front=run in front) for run in sorted(measured, key=lambda run: run.cost)),
        failures=tuple(failures),
    )


def pareto_front(runs: Sequence[MeasuredRun], error: Callable[[MeasuredRun], float]) -> list[MeasuredRun]:
    """Runs with the tolerance of the scene, and no other that is both cheaper and more accurate, cheapest first."""
    front: list[MeasuredRun] = []
    for run in sorted(runs, key=lambda one: (one.cost, error(one))):
        if run.resolution.tolerance is None and error(run) < (error(front[-1]) if front else math.inf):
            front.append(run)
    return front
