# SPDX-License-Identifier: Apache-2.0
"""Loss of a set of parameters: deviations of the fitted part of the table."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass

from drill_twin.core.errors import RunError
from drill_twin.scene import Scene
from drill_twin_evidence.paper.runs.cases import Case, changed, scene_of
from drill_twin_evidence.paper.runs.published import CRITICAL_TIME, DISPLACEMENT, FREQUENCY, RATIO, Number, published
from drill_twin_evidence.paper.runs.run import Measured, measure, run, runs_of
from drill_twin_evidence.paper.runs.table import ours_for

RUNS = (Case(40.0, 2.0), Case(20.0, 2.0), Case(150.0, 2.0), Case(300.0, 2.0), Case(40.0, 6.0))
"""Runs of the fit, at full duration: a whirl at high load may change its branch after 15 s."""
SAMPLES = 10.5
"""Frames per revolution; the analyzer needs six."""
LATERAL_UP_TO = 50.0
"""Load [N] up to which the lateral formulation, ten times faster, gives the same whirl; the slope of the helix is 0.13
at 40 N and 0.35 at 300 N, where the two formulations differ."""
LARGEST = 8.0
"""Limit of the deviation of a number, in units of 20 %."""


def fitted(number: Number) -> bool:
    """True if a number is fitted: critical times, frequencies, a ratio on each side of the surge, and mark-3."""
    if number.what in (CRITICAL_TIME, FREQUENCY):
        return True
    if number.what == RATIO:
        return number.speed in (2.0, 6.0)
    return number.what == DISPLACEMENT and number.mark == "mark_3"


FITTED = tuple(number for number in published().bench if fitted(number))
HELD_OUT = tuple(number for number in published().bench if not fitted(number))


@dataclass(frozen=True)
class Loss:
    """Loss of a set of parameters."""

    total: float
    """Sum of ln(1 + e^2) over the fitted numbers."""
    deviations: dict[str, float]
    """e by the number's name: its deviation in units of 20 %, on a logarithmic scale."""


def evaluate(scenes: Sequence[Scene], workers: int = 1, done: Callable[[Loss], None] = lambda _: None) -> list[Loss]:
    """Losses of some scenes, from the runs of the fit; a run that fails has no results.

    Args:
        scenes: The scenes.
        workers: Runs at once.
        done: Called with the loss of each scene whose runs have ended.
    """
    wanted = {(number, case): _of_fit(scene, case) for number, scene in enumerate(scenes) for case in RUNS}
    found: list[dict[Case, Measured | None]] = [{} for _ in scenes]
    losses = dict[int, Loss]()
    with closing(runs_of(_measured, wanted, workers)) as ended:
        for (number, case), measured in ended:
            found[number][case] = measured
            if len(found[number]) == len(RUNS):
                losses[number] = loss(found[number])
                done(losses[number])
    return [losses[number] for number in range(len(scenes))]


def _measured(scene: Scene, goes_on: Callable[[float], None]) -> Measured | None:
    try:
        return measure(run(scene, goes_on))
    except RunError:
        return None


def _of_fit(scene: Scene, case: Case) -> Scene:
    described = scene_of(scene, case, {"numerics.frame_rate": max(20.0, SAMPLES * case.speed)})
    return lateral(described) if case.weight_on_bit <= LATERAL_UP_TO else described


def lateral(scene: Scene) -> Scene:
    """The scene without stretch and torsion."""
    for effect in ("effects.stretch", "effects.torsion"):
        scene = changed(scene, effect, None)
    return scene


def loss(results: Mapping[Case, Measured | None]) -> Loss:
    """Cauchy loss, in which a number that contradicts the others has a bounded influence."""
    deviations = {
        number.name: deviation(ours_for(number, results.get(Case(number.weight_on_bit, number.speed))), number.value)
        for number in FITTED
    }
    return Loss(sum(math.log1p(e * e) for e in deviations.values()), deviations)


def deviation(ours: float | None, value: float) -> float:
    """|ln(ours / published)| in units of ln 1.2, at most 8; 8 where there is no such number, or it has the other sign.

    >>> round(deviation(1.2 * 0.5, 0.5), 6)
    1.0
    """
    if ours is None or not math.isfinite(ours) or ours / value <= 0.0:
        return LARGEST
    return min(abs(math.log(ours / value)) / math.log(1.2), LARGEST)
