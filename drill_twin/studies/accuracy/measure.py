# SPDX-License-Identifier: Apache-2.0
"""Measurement of an error model: runs of a scene at several resolutions, within a budget of processor time.

Runs of ever finer resolution are compared, each with the next, until one is accurate enough and the finest is at least
as fine as `auto`; then coarser resolutions are tried against the finest. Each run ends shortly after its onset.
"""

import math
import time
from collections.abc import Callable, Iterator

from drill_twin.core.errors import RunError
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.blocks.numerics import FEWEST_ELEMENTS
from drill_twin.studies.accuracy.error_model import ErrorModel, from_motions, rates
from drill_twin.studies.accuracy.errors import errors_before
from drill_twin.studies.accuracy.motion_run import Motion, run_motion

COARSEST, AUTO, FINEST = -3, 0, 2
"""Levels of refinement: at `AUTO` the elements that `auto` chooses and half its step, at each further twice as fine."""
FEWER = math.sqrt(2.0)
"""Elements over the elements of the next coarser resolution."""
HOPELESS = 0.5
"""Error at which no coarser resolution is tried [-]."""
LOOSE, TIGHT = 1e-4, 1e-6
"""Newton's tolerance of the resolutions to choose from, and of the resolutions that they are compared with."""
AFTER_ONSET = 2.0
"""Simulated time after the onset at which runs end [s]."""
BUDGET, RUNS = 60.0, 10.0
"""Most processor time of a measurement: `BUDGET` [s], or `RUNS` times the run's time, whichever is more."""

KNOWN_FROM = 0.1
"""Share done from which the time left is told: before, the rate misleads (289 s were told where 0.7 s were left)."""
Report = Callable[[str, float], None]
"""Takes a line and the share done."""


class _SpentError(Exception):
    """The budget is spent."""


class Measurement:
    """Runs of a scene at several resolutions, and the budget that they share."""

    def __init__(self, scene: Scene, accuracy: float, report: Report) -> None:
        """Choose the resolutions.

        Args:
            scene: The scene, with `elements` and `step` as `auto`.
            accuracy: The accuracy asked for [-].
            report: Takes the progress.
        """
        self._began = time.thread_time()
        self._scene, self._accuracy, self._report = scene, accuracy, report
        self._frame, self._duration = scene.numerics.frame_period, scene.rig.duration
        automatic = Twin(scene)
        self._elements = automatic.elements
        self._steps = max(1, math.ceil(self._frame / automatic.step_size - 1e-9))
        """Time steps of a frame."""
        self._fewest = max(FEWEST_ELEMENTS, len(scene.string.pieces))
        self._budget, self._speed, self._end = BUDGET, 0.0, self._duration
        self._done, self._total = 0.0, 3.0 * math.prod(self._level(AUTO))

    def model(self) -> ErrorModel:
        """Measure.

        Raises:
            RunError: No two resolutions could be run.
        """
        ladder, ended = self._refine()
        if len(ladder) < 2:
            raise RunError(
                f"{self._scene.name}: numerics.accuracy: fewer than two resolutions could be run within "
                f"{self._budget:.0f} s of processor time; give numerics.elements and numerics.step"
            )
        reference = ladder[-1]
        motions, complete = self._coarsen(reference, ladder[:-1])
        motions += ladder[:-1]
        model = from_motions(self._scene, reference, motions, ended=ended if complete else "budget")
        return from_motions(self._scene, reference, motions, later=self._later(model), ended=model.ended)

    def _refine(self) -> tuple[list[Motion], str]:
        """Runs of ever finer resolution, and what ended them."""
        ladder: list[Motion] = []
        last, failure = (0, 0), RunError("")
        for level in range(COARSEST, FINEST + 1):
            if self._level(level) == last:
                continue
            last = self._level(level)
            try:
                ladder.append(self._run(*last, TIGHT, after_onset=AFTER_ONSET))
            except _SpentError:
                return ladder, "budget"
            except RunError as error:  # too coarse to converge
                if level >= AUTO:
                    raise
                failure = error
                continue
            if len(ladder) < 2:
                continue
            if self._spare(ladder[-1], ladder[:-1]) and level >= AUTO:
                return ladder, "reached"
        if len(ladder) < 2:
            raise failure
        return ladder, "finest"

    def _coarsen(self, reference: Motion, ladder: list[Motion]) -> tuple[list[Motion], bool]:
        """Runs of at most half the elements and twice the step of the converged run, and True where all were made."""
        motions: list[Motion] = []
        hopeless: list[tuple[int, int]] = []
        resolutions = list(self._coarser(reference))
        self._total = self._done + sum(map(math.prod, resolutions))
        for elements, steps in resolutions:
            if any(elements <= n and steps <= m for n, m in hopeless):
                self._done += elements * steps
                continue
            try:
                motions.append(self._run(elements, steps, LOOSE, until=float(reference.time[-1])))
            except _SpentError:
                return motions, False
            except RunError:
                hopeless.append((elements, steps))
                continue
            if max(errors_before(motions[-1], reference)) > HOPELESS:
                hopeless.append((elements, steps))
            self._spare(reference, [*ladder, *motions])
        return motions, True

    def _coarser(self, reference: Motion) -> Iterator[tuple[int, int]]:
        """Elements, and steps of a frame: the fewest steps first, of each the most elements first."""
        most = max(1, round(self._frame / reference.step) // 2)
        steps = 1
        while steps <= most:
            elements = max(self._fewest, reference.elements // 2)
            yield elements, steps
            while elements > self._fewest:
                elements = max(self._fewest, min(elements - 1, round(elements / FEWER)))
                yield elements, steps
            steps *= 2

    def _later(self, model: ErrorModel) -> float:
        """Iterations per second after the onset over their number in the part which the runs cover."""
        point = model.cheapest(self._accuracy)
        if point is None or model.onset_s is None or model.covered_s >= self._duration:
            return 1.0
        try:
            whole = self._run(point.elements, round(self._frame / point.step), point.tolerance)
        except (_SpentError, RunError):
            return 1.0
        return rates(whole, model.onset_s)[1] / rates(whole, model.onset_s, model.covered_s)[1]

    def _level(self, level: int) -> tuple[int, int]:
        elements = max(self._fewest, round(self._elements * 2.0**level))
        return elements, max(1, round(self._steps * 2.0 ** (level + 1)))

    def _spare(self, reference: Motion, motions: list[Motion]) -> bool:
        """Set the budget by the cheapest run that is accurate enough, else by the finest; returns whether one is."""
        point = from_motions(self._scene, reference, motions).cheapest(self._accuracy)
        chosen = point and (point.elements, point.step)
        cost = next((one.cost for one in motions if (one.elements, one.step) == chosen), motions[-1].cost)
        self._budget = max(BUDGET, RUNS * cost * self._duration)
        return point is not None

    def _run(
        self, elements: int, steps: int, tolerance: float, *, until: float = math.inf, after_onset: float = math.inf
    ) -> Motion:
        """Run at a resolution.

        Raises:
            _SpentError: It would take, or took, more than what is left of the budget.
            RunError: The motion could not be followed.
        """
        step, work = self._frame / steps, elements * steps
        end = min(until, self._duration if after_onset == math.inf else self._end)
        began = time.thread_time()
        if began - self._began + self._speed * work * end > self._budget:
            raise _SpentError
        line = f"measuring what accuracy costs: {elements} elements, {step * 1e3:.3g} ms"

        def report(simulated: float) -> None:
            if time.thread_time() - self._began > self._budget:
                raise _SpentError
            done = self._done + work * min(simulated / end, 1.0)
            self._report(line, done / max(self._total, self._done + work))

        scene = at(self._scene, elements, step, tolerance)
        motion = run_motion(scene, until=until, after_onset=after_onset, progress=report)
        simulated = float(motion.time[-1])
        self._speed = (time.thread_time() - began) / (work * simulated)
        self._done += work
        if after_onset < math.inf:
            self._end = simulated
        return motion


def at(scene: Scene, elements: int, step: float, tolerance: float) -> Scene:
    """The scene at a resolution: elements, time step [s], tolerance of Newton's method."""
    chosen = {"accuracy": None, "elements": elements, "step": step, "tolerance": tolerance}
    return scene.model_copy(update={"numerics": scene.numerics.model_copy(update=chosen)})


def in_words(say: Callable[[str], object], every: float = 0.0) -> Report:
    """Progress of a measurement that is told as a text with the share done and, once a tenth tells it, the time left.

    Args:
        say: Takes the text.
        every: Least wall-clock time between two texts [s].
    """
    first, said = (math.nan, 0.0), -every

    def report(line: str, share: float) -> None:
        nonlocal first, said
        now = time.monotonic()
        if math.isnan(first[0]):
            first = now, share  # what came before, as compiling, tells nothing of the rate
        gone, done = now - first[0], share - first[1]
        if now - said >= every:
            said = now
            left = f", about {gone * (1.0 - share) / done:.0f} s left" if gone >= 1.0 and done >= KNOWN_FROM else ""
            say(f"{line}; {share:.0%} done{left}")

    return report
