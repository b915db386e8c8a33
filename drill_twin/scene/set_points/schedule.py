# SPDX-License-Identifier: Apache-2.0
"""Set-points of a scene over time: shapes, schedule, extremes."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Self

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import SceneError, TableError
from drill_twin.scene import Scene
from drill_twin.scene.blocks.rig import ADDED, RecordedTable, SetPoint
from drill_twin.scene.set_points.command import Command
from drill_twin.scene.set_points.tables import Table, read_table

SetPointAt = Callable[[float], float]
"""Time [s] -> value of a set-point."""


def shape(set_point: SetPoint) -> SetPointAt:
    """Function of time of a set-point that is not recorded.

    Raises:
        SceneError: The shape is `table`, or a shape of another package that cannot be loaded.
    """
    initial, final, start, duration = set_point.initial, set_point.value, set_point.start, set_point.duration
    if set_point.shape == "constant":
        return lambda _: final
    if set_point.shape == "step":
        return lambda time: step(time, start, initial, start + duration, final)
    if set_point.shape == "ramp":
        return lambda time: ramp(time, start, initial, start + duration, final)
    if set_point.shape in ADDED:
        return _added(set_point)
    raise SceneError(f'expected a set-point with a value, found shape "{set_point.shape}"')


def _added(set_point: SetPoint) -> SetPointAt:
    """Function of time of a set-point whose shape comes from another package."""
    entry = ADDED[set_point.shape]
    try:
        function: SetPointAt = entry.load()(set_point)
        value = float(function(0.0))
    except Exception as error:
        raise SceneError(
            f'shape "{set_point.shape}": expected a function of time from {entry.value}, found '
            f"{type(error).__name__}: {error}; mend or uninstall its package"
        ) from error
    if not math.isfinite(value):
        raise SceneError(f'shape "{set_point.shape}": expected a finite value at 0 s, found {value!r} ({entry.value})')
    return lambda time: float(function(time))


def step(time: float, start: float, before: float, end: float, after: float) -> float:
    """Cubic from `before` to `after` with zero slope at both ends (STEP of ADAMS); a jump if start = end."""
    return before + (after - before) * _smooth(_progress(time, start, end))


def ramp(time: float, start: float, before: float, end: float, after: float) -> float:
    """Straight line from `before` to `after`; a jump if start = end."""
    return before + (after - before) * _progress(time, start, end)


def table(times: Array, values: Array, start: float) -> SetPointAt:
    """Linear interpolation of measurements, from `start` [s] into the record; constant beyond its ends."""
    origin = float(times[0]) + start
    return lambda time: float(np.interp(origin + time, times, values))


def _progress(time: float, start: float, end: float) -> float:
    if time < start:
        return 0.0
    return 1.0 if time >= end else (time - start) / (end - start)


def _smooth(x: float) -> float:
    return x * x * (3.0 - 2.0 * x)


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
            TableError: No record is given, or the record cannot be used.
        """
        rig = scene.rig
        record = record_of(scene) if "table" in (rig.weight_on_bit.shape, rig.rotation.shape) else None
        start = rig.table.start if rig.table else 0.0

        def function(name: str) -> SetPointAt:
            set_point = getattr(rig, name)
            if rig.holds_values:
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
        """Set-points at times [s] from the start of the run, as a `Command`, shape (F, 3)."""
        return np.array([self.at(time) for time in times]).reshape(-1, 3)


def record_of(scene: Scene) -> Table:
    """Record of a scene's set-points of shape `table`.

    Raises:
        TableError: No record is given, or the record cannot be used.
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


SHAPE_TIMES = 10_001
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
            return float(max(ends, *(abs(over_time(time)) for time in np.linspace(0.0, rig.duration, SHAPE_TIMES))))
        if record is None or rig.table is None:
            return 0.0
        values = record.column(name)
        played = table(record.time, values, rig.table.start)
        since = record.time - record.time[0] - rig.table.start
        inside = values[(since > 0.0) & (since < rig.duration)]
        return float(np.abs([played(0.0), *inside, played(rig.duration)]).max())

    return Command(largest("weight_on_bit"), largest("rotation"))
