# SPDX-License-Identifier: Apache-2.0
"""Evaluation of a set: critical times by growth, everything by runs, of which those that cannot help are not made."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import DrillTwinError
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Schedule
from drill_twin_evidence.paper.calibration.objective import lateral
from drill_twin_evidence.paper.runs.cases import Case, changed, scene_of
from drill_twin_evidence.paper.runs.published import CRITICAL_TIME
from drill_twin_evidence.paper.search.assumptions import pair_misfits, total
from drill_twin_evidence.paper.search.growth import LinearString, critical_times, linear_string, start_of
from drill_twin_evidence.paper.search.readings import (
    FRAME_RATE,
    LEVELS,
    MARKS,
    NUMBERS,
    READINGS,
    Motion,
    Readings,
    Results,
    misfit,
    read,
)  # fmt: skip
from drill_twin_evidence.paper.search.space import (
    BIT,
    HOLE,
    INCLINATION,
    LOAD_AT,
    RADIUS,
    Trial,
    scene_of_trial,
)  # fmt: skip

ELEMENTS, STEP = 8, 0.01
"""Resolution of the runs of the search; `drill-twin paper` judges what it finds at its own."""
SECONDS = 30.0
ORDER = (
    Case(40.0, 2.0), Case(20.0, 2.0), Case(300.0, 2.0), Case(150.0, 2.0), Case(40.0, 6.0), Case(40.0, 1.0),
    Case(40.0, 4.0), Case(40.0, 3.0), Case(40.0, 6.5),
)  # fmt: skip
"""Runs of a whole set; those that decide most come first."""
TIMED = tuple(number for number in NUMBERS if number.what == CRITICAL_TIME)


class Bench:
    """The bench that sets are evaluated on.

    Attributes:
        scene: The bench in its lateral form.
        seconds: Simulated time of a run [s].
        joined: Join static and dynamic friction by STEPs.
    """

    def __init__(self, scene: Scene, seconds: float = SECONDS, *, joined: bool = False) -> None:
        """Take the bench."""
        numerics = {"numerics.elements": ELEMENTS, "numerics.step": STEP, "numerics.frame_rate": FRAME_RATE}
        self.scene, self.seconds, self.joined = lateral(scene), seconds, joined
        for key, value in numerics.items():
            self.scene = changed(self.scene, key, value)

    @cached_property
    def strings(self) -> dict[tuple[int, int], LinearString]:
        """Matrices of the growth by the choices for bit and load."""
        return {
            (bit, at): linear_string(
                changed(
                    changed(self.scene, "string.bit_end", ("sliding", "guided")[bit]), "rig.weight_on_bit.at", place
                )
            )
            for bit in (0, 1)
            for at, place in enumerate(("bit", "top"))
        }

    def grows(self, one: Trial) -> bool:
        """True if growth from the axis says when a set begins to whirl: in a vertical hole, by a bit without play."""
        return one.choices[INCLINATION] == 0 and one.choices[BIT] < 2

    def grown_times(self, one: Trial) -> Array | None:
        """Critical times in each reading by growth alone [s], shape (3, readings); None where it says nothing."""
        if not self.grows(one):
            return None
        string = self.strings[one.choices[BIT], one.choices[LOAD_AT]]
        clearance = RADIUS[one.choices[HOLE]] - self._surface
        limits = np.array([level if level > 0.0 else -level * clearance for level in LEVELS.values()])
        starts = (start_of(one, number.weight_on_bit, number.speed) for number in TIMED)
        return np.array([critical_times(string, start, limits, self.seconds) for start in starts])

    def grown(self, one: Trial) -> Array | None:
        """Misfits of `grown_times`."""
        times = self.grown_times(one)
        if times is None:
            return None
        empty = np.empty(0)
        rows = zip(TIMED, times, strict=True)
        return np.array([misfit(number, Readings(row, empty, empty, 0.0)) for number, row in rows])

    @cached_property
    def _surface(self) -> float:
        return 0.5 * self.scene.string.sections[0].outer_diameter

    def run(self, one: Trial, case: Case, changes: Mapping[str, Any] | None = None) -> Readings | None:
        """Readings of one run of a set, with other values of its scene changed; None where it fails."""
        motion = self.motion(one, case, changes)
        return None if motion is None else read(motion)

    def motion(self, one: Trial, case: Case, changes: Mapping[str, Any] | None = None) -> Motion | None:
        """Motion of one run of a set; None where it fails."""
        scene = scene_of(scene_of_trial(self.scene, one), case, changes)
        try:
            twin, schedule = Twin(scene), Schedule.from_scene(scene)
            times = np.arange(1, round(self.seconds * FRAME_RATE) + 1) / FRAME_RATE
            commands = schedule.over(times)
            rows = twin.rows(times.size)
            twin.advance_frames(commands, 1.0 / FRAME_RATE, rows)
        except DrillTwinError:
            return None
        places = [mark.name for mark in scene.string.marks]
        centre = rows.centre[:, [places.index(mark) for mark in MARKS]]
        angle = np.cumsum(commands[:, 1]) / FRAME_RATE
        return Motion(rows.time, centre[..., 0] + 1j * centre[..., 1], angle, self._surface, scene.least_clearance)


def failed() -> Readings:
    """Readings of a run that failed: none is near."""
    time, whirl, size = (np.full(len(names), math.nan) for names in READINGS.values())
    return Readings(time, whirl, np.tile(size, (len(MARKS), 1)), 0.0)


def evaluate_pair(bench: Bench, one: Trial, pair: tuple[int, int], least: float, *, any_reading: bool) -> Results:
    """Runs of a set for two numbers; the second only if the first, alone, is nearer than the least misfit known."""
    results: Results = {}
    for k in pair:
        case = Case(NUMBERS[k].weight_on_bit, NUMBERS[k].speed)
        if case not in results:
            results[case] = bench.run(one, case) or failed()
        if pair_misfits(results, any_reading=any_reading)[k, k] >= least:
            break
    return results


def evaluate_whole(bench: Bench, one: Trial, most: float, *, any_reading: bool) -> Results:
    """Runs of a set for all numbers, until its total is beyond the most that is of use."""
    results: Results = {}
    for case in ORDER:
        results[case] = bench.run(one, case) or failed()
        if total(results, any_reading=any_reading) >= most:
            break
    return results
