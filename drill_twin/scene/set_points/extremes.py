# SPDX-License-Identifier: Apache-2.0
"""Extremes of a schedule."""

import numpy as np

from drill_twin.scene import Scene
from drill_twin.scene.set_point_shapes import ADDED
from drill_twin.scene.set_points.command import Command
from drill_twin.scene.set_points.schedule import record_of
from drill_twin.scene.set_points.shapes import shape, table

SAMPLES = 10_001
"""Times at which a shape of another package is evaluated, evenly over the run."""


def extremes(scene: Scene) -> Command:
    """Largest weight on bit in size [N] and fastest rotation [rad/s] of a scene's whole schedule.

    0 for a record without a file.

    Raises:
        TableError: A record that cannot be used.
    """
    rig = scene.rig
    plays = "table" in (rig.weight_on_bit.shape, rig.rotation.shape)
    record = record_of(scene) if plays and rig.table and rig.table.file else None

    def largest(name: str) -> float:
        set_point = getattr(rig, name)
        if set_point.shape != "table":
            ends = max(abs(set_point.value), abs(set_point.initial))
            if set_point.shape not in ADDED:
                return float(ends)
            over_time = shape(set_point)
            return float(max(ends, *(abs(over_time(time)) for time in np.linspace(0.0, rig.duration, SAMPLES))))
        if record is None or rig.table is None:
            return 0.0
        values = record.column(name)
        played = table(record.time, values, rig.table.start)
        since = record.time - record.time[0] - rig.table.start
        inside = values[(since > 0.0) & (since < rig.duration)]
        return float(np.abs([played(0.0), *inside, played(rig.duration)]).max())

    return Command(largest("weight_on_bit"), largest("rotation"))
