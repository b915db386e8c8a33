# SPDX-License-Identifier: Apache-2.0
"""The cost curve of a scene: error and time of every rung of a ladder of resolutions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from drill_twin.accuracy.error_model import Promise, from_motions
from drill_twin.accuracy.errors import Errors, compare, spread
from drill_twin.accuracy.motion_run import Motion, kept_run
from drill_twin.errors import RunError, SceneError
from drill_twin.scene import Scene, load_scene
from drill_twin.studies.pool import run_jobs
from drill_twin.twin.twin import Twin

ELEMENTS = (0.375, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
"""Elements of the rungs over those that `auto` chooses."""
STEPS = (2.0, 1.0, 0.5, 0.25, 0.125)
"""Steps of the rungs over that which `auto` chooses; none is longer than a frame."""
TOLERANCES = (1e-3, 1e-4, 1e-6)
"""Tolerances of Newton's method that are tried beside the scene's own, at the resolution that `auto` chooses."""
FINER = 2.0
"""Elements of the converged run over those of the finest rung; its step is as many times shorter."""
FEWEST = 4
SPATIAL, LATERAL = "spatial", "lateral"


@dataclass(frozen=True)
class Rung:
    """One resolution."""

    form: str
    elements: int
    step: float
    tolerance: float | None = None
    """Of Newton's method; None: the scene's."""

    @property
    def words(self) -> str:
        """For people."""
        tolerance = "" if self.tolerance is None else f", tolerance {self.tolerance:.0e}"
        return f"{self.form}, {self.elements} elements, {self.step * 1e3:.3g} ms{tolerance}"

    def overrides(self) -> dict[str, str]:
        """Changes to the scene that select it."""
        numerics = {
            "numerics.accuracy": "null", "numerics.elements": str(self.elements), "numerics.step": f"{self.step!r} s",
        }  # fmt: skip
        off = {"effects.stretch": "off", "effects.torsion": "off"} if self.form == LATERAL else {}
        own = {} if self.tolerance is None else {"numerics.tolerance": repr(self.tolerance)}
        return numerics | off | own


@dataclass(frozen=True)
class Measured:
    """A rung and what it showed."""

    rung: Rung
    errors: Errors
    cost: float
    """Processor time per simulated second [s/s]."""
    realtime_factor: float
    frame_p95: float
    """Processor time that 95 % of the frames stayed below [s]."""
    compile_seconds: float
    iterations: float
    """Newton iterations per simulated second [1/s]."""
    on_front: bool = False
    """Whether no other rung is both cheaper and more accurate in what `accuracy` promises."""


@dataclass(frozen=True)
class Curve:
    """The cost curve of one scene."""

    scene: str
    version: str
    reference: Rung
    noise: Errors
    """Spread of replicas of the converged run: no error below it can be told."""
    onset_s: float | None
    """Onset of the converged run [s]."""
    rungs: tuple[Measured, ...]
    promise: Promise
    """The same for `accuracy`, in the scene's own form."""
    failures: tuple[str, ...] = ()
    """Rungs without a run, and why."""

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON."""
        return asdict(self)

    @property
    def front(self) -> list[Measured]:
        """The rungs worth choosing, cheapest first."""
        return sorted((rung for rung in self.rungs if rung.on_front), key=lambda rung: rung.cost)


def ladder(scene: Scene, elements: tuple[float, ...] = ELEMENTS, steps: tuple[float, ...] = STEPS) -> list[Rung]:
    """The rungs to try: multiples of what `auto` chooses, in the scene's form and, if it may, in the lateral one."""
    numerics = scene.numerics.model_copy(update={"elements": "auto", "step": "auto", "accuracy": None})
    twin = Twin(scene.model_copy(update={"numerics": numerics}))
    sections = len(scene.string.sections)
    counts = sorted({max(FEWEST, sections, round(share * twin.elements)) for share in elements})
    frame = 1.0 / scene.numerics.frame_rate
    lengths = sorted({min(share * twin.step_size, frame) for share in steps}, reverse=True)
    rungs = [Rung(form, count, length) for form in forms(scene) for count in counts for length in lengths]
    plain = (rungs[0].form, max(FEWEST, sections, twin.elements), min(twin.step_size, frame))
    return rungs + [Rung(*plain, tolerance) for tolerance in TOLERANCES]


def forms(scene: Scene) -> list[str]:
    """The scene's own form of the string, and the lateral one if none of its effects needs more."""
    if scene.effects.stretch is None:
        return [LATERAL]
    needing = [key for key, block in scene.effects.blocks.items() if {"stretch", "torsion"} & set(block.requires)]
    return [SPATIAL] if needing else [SPATIAL, LATERAL]


def converged(rungs: list[Rung]) -> Rung:
    """The run that counts as exact: the first form, finer than the finest rung."""
    return Rung(
        rungs[0].form,
        round(FINER * max(rung.elements for rung in rungs)),
        min(rung.step for rung in rungs) / FINER,
    )


def measure(
    scene: str,
    overrides: Mapping[str, str],
    rungs: list[Rung],
    folder: Path,
    *,
    replicas: int = 3,
    workers: int = 2,
    progress: Callable[[str], None] = lambda _: None,
) -> Curve:
    """Run every rung and the converged run, and compare.

    Args:
        scene: Name or file of the scene.
        overrides: Changes to it.
        rungs: What to try; see `ladder`.
        folder: Where runs are kept, so that a study that was broken off goes on.
        replicas: Runs beside the converged one that tell how uncertain its statistics are.
        workers: Processes; with fewer than cores the times are cleaner.
        progress: Called with a line whenever a run is done.

    Raises:
        SceneError: The scene is none.
        RunError: The converged run fails.
    """
    from drill_twin import __version__

    described = load_scene(scene, overrides=dict(overrides))
    exact = converged(rungs)
    keys: list[tuple[Rung, int | None]] = [(exact, None), *((exact, seed) for seed in range(replicas))]
    keys += [(rung, None) for rung in rungs]
    jobs = {(rung, seed): (scene, {**overrides, **rung.overrides()}, seed, folder) for rung, seed in keys}
    done = run_jobs(kept_run, jobs, workers, done=lambda key, _: progress(key[0].words))
    reference = done[exact, None]
    if isinstance(reference, str):
        raise RunError(f"the converged run of {described.name} failed: {reference}")
    others = [motion for seed in range(replicas) if isinstance(motion := done[exact, seed], Motion)]
    measured, own, failures = [], [], []
    for rung in rungs:
        motion = done[rung, None]
        if isinstance(motion, str):
            failures.append(f"{rung.words}: {motion}")
        else:
            measured.append(_measured(rung, motion, reference))
            if rung.form == exact.form:
                own.append(motion)
    if not measured:
        raise SceneError(f"none of the resolutions of {described.name} could be run; the first: {failures[0]}")
    return Curve(
        scene=described.name,
        version=__version__,
        reference=exact,
        noise=spread(others, reference),
        onset_s=None if reference.onset != reference.onset else reference.onset,
        rungs=tuple(_with_front(measured)),
        promise=from_motions(described, reference, own),
        failures=tuple(failures),
    )


def _measured(rung: Rung, motion: Motion, reference: Motion) -> Measured:
    return Measured(
        rung=rung,
        errors=compare(motion, reference),
        cost=motion.cost,
        realtime_factor=1.0 / motion.cost,
        frame_p95=motion.frame_p95,
        compile_seconds=motion.compile_seconds,
        iterations=motion.iterations,
    )


def _with_front(measured: list[Measured]) -> list[Measured]:
    best, result = float("inf"), []
    for one in sorted(measured, key=lambda rung: (rung.cost, rung.errors.promised)):
        on_front = one.rung.tolerance is None and one.errors.promised < best
        best = one.errors.promised if on_front else best
        result.append(Measured(**{**one.__dict__, "on_front": on_front}))
    return result
