# SPDX-License-Identifier: Apache-2.0
"""Motion and measured channels over time: memory grows with the run."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.frame_record import FrameSeries, RigSeries
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.model.mesh import SPIN
from drill_twin.runs.ensemble.outputs.collector import Collector, Request, Variable

_CHANNEL_UNITS = {"top_drive_torque": "N m", "motor_torque": "N m", "bit_torque": "N m", "top_drive_speed": "rad/s",
                  "bit_speed": "rad/s"}  # fmt: skip


class Marks(Collector):
    """Centre line at the marks at a rate."""

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        samples, marks = math.ceil(request.frames / request.every), len(twin.scene.string.marks)
        self._time, self._centre = np.full(samples, np.nan), np.full((samples, marks, 2), np.nan)
        self._frames = self._samples = 0

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Keep every n-th frame."""
        del rig
        first = -self._frames % self.request.every
        time, centre = rows.time[first :: self.request.every], rows.centre[first :: self.request.every, :, :2]
        place = slice(self._samples, self._samples + time.size)
        self._time[place], self._centre[place] = time, centre
        self._frames += rows.time.size
        self._samples += time.size

    def close(self) -> Mapping[str, Variable]:
        """Times and positions."""
        return {
            "time": Variable(np.round(self._time, 9), ("sample",), "s"),
            "centre": Variable(self._centre, ("sample", "mark", "axis"), "m"),
        }


class Channels(Collector):
    """Channels that a rig measures, each the mean since the last sample; `motor_torque` is with the drive's inertia."""

    def __init__(self, twin: Twin, request: Request) -> None:
        super().__init__(twin, request)
        self._rows: list[Array] = []
        self._speeds = np.array((twin.unknowns[1][-1, SPIN], twin.unknowns[1][0, SPIN]))

    def add(self, rows: FrameSeries, rig: RigSeries) -> None:
        """Add the frames: means of the forces as they are, of the speeds from those at their ends."""
        drive = self.twin.scene.rig.top_drive
        speeds = np.column_stack((self._speeds, (rig.top_drive_speed, rig.bit_speed)))
        top, bit = 0.5 * (speeds[:, 1:] + speeds[:, :-1])
        motor = rig.top_drive_torque + drive.inertia * np.diff(speeds[0]) / self.request.period + drive.damping * top
        self._speeds = speeds[:, -1]
        means = rig._replace(top_drive_speed=top, bit_speed=bit)
        self._rows.append(np.array((rows.time, *means, motor)))

    def close(self) -> Mapping[str, Variable]:
        """Times of the ends of the samples, and values by channel."""
        every, samples = self.request.every, self.request.frames // self.request.every
        table = np.full((len(RigSeries._fields) + 2, samples), np.nan)
        frames = np.concatenate(self._rows, axis=1)
        count = frames.shape[1] // every
        parts = frames[:, : count * every].reshape(len(table), count, every)
        table[:, :count] = parts.mean(axis=2)
        table[0, :count] = parts[0, :, -1]
        time, *values = table
        names = (*RigSeries._fields, "motor_torque")
        return {"time": Variable(np.round(time, 9), ("sample",), "s")} | {
            name.replace("top_drive_torque", "torque"): Variable(value, ("sample",), _CHANNEL_UNITS.get(name, "N"))
            for name, value in zip(names, values, strict=True)
        }
