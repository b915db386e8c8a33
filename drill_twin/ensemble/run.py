# SPDX-License-Identifier: Apache-2.0
"""Runs of the members of an ensemble, and the threads that make them: the compiled frame loop releases the GIL."""

from __future__ import annotations

import time
from collections.abc import Generator, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from functools import partial
from typing import Protocol

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.ensemble.members import Member, Members, scene_of
from drill_twin.ensemble.outputs import OUTPUTS, Request, Variable, collect, first_rows
from drill_twin.errors import DrillTwinError
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.scene import Scene
from drill_twin.schedule import Schedule
from drill_twin.twin.twin import Twin

CHUNK = 4096
"""Frames in one call of the compiled loop; they are given to the outputs, then overwritten."""


@dataclass(frozen=True)
class Run:
    """Outcome of a member.

    Attributes:
        values: Its outputs by name; of a member that failed, of the frames before.
        failure: The reason why it could not be followed to the end; empty for one that was.
        simulated: Simulated time [s].
        repeated: Frames that the step guard repeated with a smaller step.
        kernel_seconds: Processor time in the compiled loop [s].
        processor_seconds: Processor time in all [s].
    """

    values: Mapping[str, Variable] = field(default_factory=dict)
    failure: str = ""
    simulated: float = 0.0
    repeated: int = 0
    kernel_seconds: float = 0.0
    processor_seconds: float = 0.0


class Executor(Protocol):
    """Place where members are run: `Threads` of this process, or `drill_twin.ensemble.dask_workers.DaskWorkers`."""

    def run(self, members: Members, request: Request) -> Generator[tuple[int, Run]]:
        """Run all members; the same bits wherever they are run.

        Args:
            members: The members.
            request: Outputs.

        Yields:
            Number and outcome of each member, as they end.

        Raises:
            RunError: The place cannot run them; a member that fails is an outcome.
        """


@dataclass(frozen=True)
class Threads:
    """Threads of this process.

    Attributes:
        workers: Number of threads.
    """

    workers: int = 1

    def run(self, members: Members, request: Request) -> Generator[tuple[int, Run]]:
        """As in `Executor`."""
        pool = ThreadPoolExecutor(min(self.workers, len(members)), "member")
        try:
            run = partial(run_member, members.base, request)
            waiting = {pool.submit(run, member): member.number for member in members}
            for future in as_completed(waiting):
                yield waiting.pop(future), future.result()
        finally:
            pool.shutdown(cancel_futures=True)


def run_member(base: Scene, request: Request, member: Member) -> Run:
    """Run one member of a base scene; its failure is part of the outcome."""
    began = time.thread_time()
    kernel, repeated, failure, simulated = 0.0, 0, "", 0.0
    values: dict[str, Variable] = {}
    try:
        scene = scene_of(base, member)
        twin = Twin(scene)
        commands = set_points(Schedule.from_scene(scene), request)
        collectors = [OUTPUTS[name](twin, request) for name in request.names]
        rows = twin.rows(min(CHUNK, request.frames))
        for first in range(0, request.frames, CHUNK):
            chunk = commands[first : first + CHUNK]
            start = time.thread_time()
            try:
                repeated += twin.advance_frames(chunk, request.period, rows)
            except DrillTwinError as error:
                failure = str(error)
            kernel += time.thread_time() - start
            simulated = twin.time
            count = round(simulated / request.period) - first
            collect(collectors, twin, first_rows(rows, count), request.period)
            if failure:
                break
        if simulated > 0.0:
            for collector in collectors:
                values |= collector.close()
    except DrillTwinError as error:
        failure = failure or str(error)
    except MemoryError:
        failure = (
            f"{member}: expected room for its arrays, found no memory left; take fewer workers or a lower mark_rate"
        )
    return Run(values, failure, simulated, repeated, kernel, time.thread_time() - began)


def set_points(schedule: Schedule, request: Request) -> Array:
    """Set-points at the end of each frame: weight on bit [N], rotation [rad/s], speed of a block [m/s] if any."""
    period = round(request.period * NANOSECONDS)
    times = [seconds(frame * period) for frame in range(1, request.frames + 1)]
    planned = [schedule.weight_on_bit, schedule.rotation, *([schedule.block] if schedule.block else [])]
    return np.array([[set_point(at) for at in times] for set_point in planned]).T.copy()
