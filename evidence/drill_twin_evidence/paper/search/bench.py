# SPDX-License-Identifier: Apache-2.0
"""The bench that sets of numbers are evaluated on: an ensemble of runs for each kernel."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drill_twin.api.ensemble import Ensemble
from drill_twin.dynamics.twin.dynamics import kernel_of
from drill_twin.runs.ensemble.run import MemberRun
from drill_twin.scene import Scene
from drill_twin.scene.load import override
from drill_twin.scene.set_points import Schedule
from drill_twin_evidence.paper.runs.cases import Case
from drill_twin_evidence.paper.search.readings import FRAME_RATE, MARKS, Motion, Readings, failed, read
from drill_twin_evidence.paper.search.space import ParameterSet

LATERAL = {"effects.stretch": "off", "effects.torsion": "off"}
"""Keys of the lateral form, ten times faster."""
COARSE = {"numerics.elements": 8, "numerics.step": 0.01}
"""Resolution of the runs of the search; `drill-twin study paper` judges what it finds at its own."""


@dataclass(frozen=True)
class Bench:
    """The bench.

    Attributes:
        scene: The bench as it is judged.
        seconds: Simulated time of a run [s]; None: that of the scene.
        joined: Join static and dynamic friction by STEPs.
        workers: Runs at a time.
        resolution: Elements and step, by their keys.
        lateral_up_to: Load up to which runs are made in the lateral form [N].
        ended: Called as each run ends.
    """

    scene: Scene
    seconds: float | None = 30.0
    joined: bool = False
    workers: int = 1
    resolution: Mapping[str, float] = field(default_factory=lambda: COARSE)
    lateral_up_to: float = math.inf
    ended: Callable[[], None] = lambda: None

    def run(
        self, wanted: Sequence[tuple[ParameterSet, Case]], changes: Mapping[str, Any] | None = None
    ) -> list[Readings]:
        """Readings of runs of sets, with other values by key changed; of a run that fails no number is near."""
        found = zip(wanted, self.motions(wanted, changes), strict=True)
        return [failed(case) if motion is None else read(case, motion) for (_, case), motion in found]

    def motions(
        self, wanted: Sequence[tuple[ParameterSet, Case]], changes: Mapping[str, Any] | None = None
    ) -> list[Motion | None]:
        """Motions of such runs; None where one fails."""
        base = override(self.scene, {"numerics.frame_rate": FRAME_RATE})
        members = [self._keys(*one) | dict(changes or {}) for one in wanted]
        scenes = [override(base, keys) for keys in members]
        groups = defaultdict[Any, list[int]](list)
        for number, (keys, scene) in enumerate(zip(members, scenes, strict=True)):
            groups[kernel_of(scene), tuple(keys)].append(number)
        found = dict[int, Motion | None]()
        for (_, keys), numbers in groups.items():
            vary = {key: [members[number][key] for number in numbers] for key in keys}
            done = Ensemble(base, vary, zipped=True).run(
                self.seconds, outputs="marks", mark_rate=FRAME_RATE, workers=self.workers,
                progress=lambda _done, _of: self.ended(),
            )  # fmt: skip
            found |= {number: _motion(scenes[number], run) for number, run in zip(numbers, done.runs, strict=True)}
        return [found[number] for number in range(len(members))]

    def _keys(self, one: ParameterSet, case: Case) -> dict[str, Any]:
        form = LATERAL if case.weight_on_bit <= self.lateral_up_to else {}
        return form | dict(self.resolution) | one.keys() | case.keys()


def _motion(scene: Scene, run: MemberRun) -> Motion | None:
    if run.failure:
        return None
    time, centre = run.values["time"].value, run.values["centre"].value
    names = [mark.name for mark in scene.string.marks]
    centre = centre[:, [names.index(mark) for mark in MARKS]]
    angle = np.cumsum(Schedule.from_scene(scene).over(time)[:, 1]) / FRAME_RATE
    surface = 0.5 * scene.string.sections[0].outer_diameter
    return Motion(time, centre[..., 0] + 1j * centre[..., 1], angle, surface, scene.least_clearance)
