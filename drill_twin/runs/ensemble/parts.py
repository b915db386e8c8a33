# SPDX-License-Identifier: Apache-2.0
"""Runs in parts: as many frames in one call of compiled code as their memory allows."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import NamedTuple

from drill_twin.core.arrays import Array
from drill_twin.core.errors import DrillTwinError
from drill_twin.dynamics.twin.frame import Frames
from drill_twin.dynamics.twin.frame_record import FrameSeries, RigSeries
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Schedule

CHUNK = 4096
"""Most frames in one call of the compiled loop."""
MOST_BYTES = 4 * 1024 * 1024
"""Most memory of the frames of one call where the state of all nodes is recorded."""


class Chunk(NamedTuple):
    """Frames that were computed together; the arrays hold until the next chunk is computed."""

    rows: FrameSeries
    rig: RigSeries
    seconds: float
    """Processor time of the compiled loop [s]."""

    def first(self, count: int) -> Chunk:
        """The first frames of the chunk, with the effort of the whole chunk."""
        rows, rig = ([column[:count] for column in part] for part in (self.rows, self.rig))
        return self._replace(rows=FrameSeries(*rows), rig=RigSeries(*rig))


def parts_of(twin: Twin, commands: Array, period: float, size: int | None = None) -> Iterator[Chunk]:
    """Advance a twin that has not run, part by part: motion of marks and rig.

    Args:
        twin: The twin.
        commands: Set-points at the end of each frame, as `Schedule.over` makes them.
        period: Length of a frame [s].
        size: Most frames of a part; `CHUNK` unless given.

    Raises:
        DrillTwinError: A frame could not be followed; the frames before it have been yielded.
    """
    record = twin.record(min(size or CHUNK, len(commands)), nodes=False)
    rows, rig = record.frames, RigSeries.of(record.frames)
    twin.load()  # outside the timed part
    for first in range(0, len(commands), record.size):
        began, error = time.thread_time(), None
        try:
            twin.advance_frames(commands[first : first + record.size], period, record)
        except DrillTwinError as ended:
            error = ended
        part = Chunk(rows, rig, time.thread_time() - began)
        if count := round(twin.time / period) - first:
            yield part.first(count)
        if error is not None:
            raise error


def frames_of(twin: Twin, commands: Array, period: float, size: int | None = None) -> Iterator[Frames]:
    """As `parts_of`, with the state of all nodes; the balance of an energy audit is of the last frame of a part."""
    most = MOST_BYTES // twin.record(1).table.nbytes
    record = twin.record(max(1, min(size or CHUNK, len(commands), most)))
    for first in range(0, len(commands), record.size):
        frames, error = twin.fill(record, commands[first : first + record.size], period)
        if frames.time.size:
            yield frames
        if error is not None:
            raise error


def planned(scene: Scene, duration: float | None = None) -> tuple[Array, float]:
    """Set-points of a scene at the end of each frame, to its end or for a time [s], and the length of a frame [s]."""
    period = scene.numerics.frame_period
    schedule = Schedule.from_scene(scene)
    frames = max(1, round((schedule.duration if duration is None else duration) / period))
    return schedule.over(frame * period for frame in range(1, frames + 1)), period
