# SPDX-License-Identifier: Apache-2.0
"""drill_twin: cubic elements, implicit midpoint; stretch and torsion are unknowns in every run.

The cost holds what a user pays: set-points and a published frame (poses, marks, reactions) every 10 ms. Wall and
friction act at two Gauss points of each element and are in Newton's tangent. With them Newton's tolerance is 1e-4, as
Exudyn's is: the errors are the same as with the default 1e-5.
"""

from __future__ import annotations

import numpy as np

from drill_twin.core.errors import RunError
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points import Schedule
from drill_twin_evidence.benchmarks.peers.rod import scene_of
from drill_twin_evidence.benchmarks.peers.task import Motion, Recorder, Task


def run(task: Task) -> Motion:
    """Run a task; `options` are further overrides of the scene."""
    scene = scene_of(task)
    schedule = Schedule.from_scene(scene)
    period = 1.0 / scene.numerics.frame_rate
    Twin(scene).advance(schedule.at(period), period)  # compiles
    twin = Twin(scene)
    bottom = float(twin.unknowns[0][0, 2])
    recorder = Recorder(task.limit)
    for frame_number in range(1, round(schedule.duration / period) + 1):
        try:
            frame = twin.advance(schedule.at(frame_number * period), period)
        except RunError as error:
            recorder.failure = str(error)
            break
        recorder.steps += frame.stats.steps
        places = frame.positions
        reach = float(np.hypot(places[:, 0], places[:, 1]).max())
        if not recorder.take(frame.time, frame.marks.centre[0], float(places[0, 2]) - bottom, reach):
            break
    return recorder.motion()
