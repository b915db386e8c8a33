# SPDX-License-Identifier: Apache-2.0
"""Set-points of a scene over time."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Self

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import TableError
from drill_twin.scene import Scene
from drill_twin.scene.blocks.rig import RecordedTable
from drill_twin.scene.set_points.command import Command
from drill_twin.scene.set_points.shapes import SetPointAt, shape, table
from drill_twin.scene.set_points.tables import Table, read_table


@dataclass(frozen=True)
class Schedule:
    """Set-points over time; the same for the rig driver's topics and for a run without ROS."""

    weight_on_bit: SetPointAt
    """Time [s] -> weight on bit [N]."""
    rotation: SetPointAt
    """Time [s] -> speed of the top drive [rad/s]."""
    duration: float
    """Duration of the scene [s]; afterwards the last set-points hold."""
    record: Table | None = None
    """Recorded table of the scene, if any."""
    block: SetPointAt | None = None
    """Time [s] -> speed of the travelling block [m/s]; None without one."""

    @classmethod
    def from_scene(cls, scene: Scene) -> Self:
        """Make the schedule of a scene; reads the record if a set-point has shape `table`.

        Raises:
            TableError: No record given, or one that cannot be used.
        """
        rig = scene.rig
        record = record_of(scene) if "table" in (rig.weight_on_bit.shape, rig.rotation.shape) else None
        start = rig.table.start if rig.table else 0.0

        def function(name: str) -> SetPointAt:
            set_point = getattr(rig, name)
            if rig.start != "axis":
                return lambda _: float(set_point.value)
            if set_point.shape != "table" or record is None:
                return shape(set_point)
            return table(record.time, record.column(name), start)

        block = shape(rig.block) if rig.block else None
        return cls(function("weight_on_bit"), function("rotation"), rig.duration, record, block)

    def at(self, time: float) -> Command:
        """Set-points at a time [s] from the start of the run."""
        return Command(self.weight_on_bit(time), self.rotation(time), self.block(time) if self.block else 0.0)

    def over(self, times: Iterable[float]) -> Array:
        """Set-points at times [s] from the start of the run, as `Command.values`, shape (F, 3)."""
        return np.array([self.at(time).values for time in times]).reshape(-1, 3)


def record_of(scene: Scene) -> Table:
    """Record of a scene's set-points of shape `table`.

    Raises:
        TableError: No record given, or one that cannot be used.
    """
    source = scene.rig.table
    if source is None or not source.file:
        raise TableError(
            f"scene {scene.name}: rig.table.file: expected the CSV, MAT, LAS or WITSML file of the record to play, "
            'found none; give it as the override "rig.table.file=PATH" or write it into the scene'
        )
    wanted = tuple(name for name in ("weight_on_bit", "rotation") if getattr(scene.rig, name).shape == "table")
    file = Path(source.file)
    there = file.stat() if file.is_file() else None
    return _read(source, wanted, (there.st_mtime_ns, there.st_size) if there else None)


@lru_cache(maxsize=1)  # a run reads it three times: for the resolution of its twins and for its set-points
def _read(
    source: RecordedTable,
    wanted: tuple[str, ...],
    stamp: tuple[int, int] | None,  # noqa: ARG001 - part of the cache's key: changes with the file's content
) -> Table:
    return read_table(
        source.file,
        time=source.time,
        weight_on_bit=source.weight_on_bit,
        rotation=source.rotation,
        wanted=wanted,
        longest_gap=source.longest_gap,
        spike_window=source.spike_window,
    )
