# SPDX-License-Identifier: Apache-2.0
"""Runs of the members of an ensemble, and the threads that make them: the compiled frame loop releases the GIL."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Hashable, Mapping, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from threading import Event
from typing import Protocol, TypeVar

import numpy as np

from drill_twin.base.arrays import Array
from drill_twin.ensemble.members import Member, Members, scene_of
from drill_twin.ensemble.outputs import OUTPUTS, Collector, Request, Variable, collect, first_rows
from drill_twin.errors import DrillTwinError
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.runner.compilation import compile_kernel
from drill_twin.scene import Scene
from drill_twin.schedule import Schedule
from drill_twin.twin.dynamics import kernel_of
from drill_twin.twin.frame import Frames
from drill_twin.twin.frame_kernel import Rows
from drill_twin.twin.observer import Record
from drill_twin.twin.twin import Twin

Key = TypeVar("Key", bound=Hashable)

CHUNK = 4096
"""Most frames in one call of the compiled loop; they are given to the outputs, then overwritten."""
MOST_BYTES = 4 * 1024 * 1024
"""Most memory of the frames of one call where the state of all nodes is recorded."""


@dataclass(frozen=True)
class Run:
    """Outcome of a member.

    Attributes:
        values: Its outputs by name; of a member that failed, of the frames before.
        failure: The reason why it could not be followed to the end; empty for one that was.
        simulated: Simulated time [s].
        repeated: Frames that the step guard repeated with a smaller step.
        spent: Frames of each call of the compiled loop, and its processor time [s].
        processor_seconds: Processor time in all [s].
    """

    values: Mapping[str, Variable] = field(default_factory=dict)
    failure: str = ""
    simulated: float = 0.0
    repeated: int = 0
    spent: tuple[tuple[int, float], ...] = ()
    processor_seconds: float = 0.0

    @property
    def kernel_seconds(self) -> float:
        """Processor time in the compiled loop [s]."""
        return sum(seconds for _, seconds in self.spent)


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
        run = partial(run_member, members.base, request)
        yield from _on_threads({member.number: partial(run, member) for member in members}, self.workers, Event())


def run_scenes(
    scenes: Mapping[Key, Scene], outputs: Sequence[Callable[[Twin, Request], Collector]], workers: int
) -> Generator[tuple[Key, Run]]:
    """Run scenes to their ends on threads; one that fails is an outcome and stops no other.

    Args:
        scenes: Scenes by key; they may have other kernels, which are compiled or loaded first.
        outputs: Make the collectors of each.
        workers: Threads.

    Yields:
        Key and outcome of each scene, as they end.
    """
    for scene in {kernel_of(scene): scene for scene in scenes.values()}.values():
        with suppress(DrillTwinError):  # it is the failure of each run then
            compile_kernel(scene, 1.0 / scene.numerics.frame_rate, analysis=True)
    stop = Event()

    def to_end(scene: Scene) -> Run:
        try:
            return run_scene(scene, outputs, *frames_of(scene), progress=goes_on)
        except DrillTwinError as error:
            return Run(failure=str(error))

    def goes_on(_time: float) -> None:
        if stop.is_set():
            raise CancelledError

    yield from _on_threads({key: partial(to_end, scene) for key, scene in scenes.items()}, workers, stop)


def _on_threads(jobs: Mapping[Key, Callable[[], Run]], workers: int, stop: Event) -> Generator[tuple[Key, Run]]:
    pool = ThreadPoolExecutor(max(1, min(workers, len(jobs))), "member")
    try:
        waiting = {pool.submit(job): key for key, job in jobs.items()}
        for future in as_completed(waiting):
            yield waiting.pop(future), future.result()
    finally:
        stop.set()
        pool.shutdown(cancel_futures=True)


def run_member(base: Scene, request: Request, member: Member) -> Run:
    """Run one member of a base scene; its failure is part of the outcome."""
    began = time.thread_time()
    try:
        scene = scene_of(base, member)
        period = round(request.period * NANOSECONDS)
        commands = set_points(scene, [seconds(frame * period) for frame in range(1, request.frames + 1)])
        run = run_scene(scene, [OUTPUTS[name] for name in request.names], request, commands)
    except DrillTwinError as error:
        run = Run(failure=str(error))
    except MemoryError:
        none = "expected room for its arrays, found no memory left; take fewer workers or a lower mark_rate"
        run = Run(failure=f"{member}: {none}")
    return replace(run, processor_seconds=time.thread_time() - began)


def frames_of(scene: Scene, duration: float | None = None) -> tuple[Request, Array]:
    """Frames of a scene to its end, or for a time [s], and the set-points at their ends, for `run_scene`."""
    period = 1.0 / scene.numerics.frame_rate
    frames = max(1, round((Schedule.from_scene(scene).duration if duration is None else duration) / period))
    return Request((), period, frames, 1), set_points(scene, [frame * period for frame in range(1, frames + 1)])


def run_scene(
    scene: Scene,
    outputs: Sequence[Callable[[Twin, Request], Collector]],
    request: Request,
    commands: Array,
    *,
    begin: Callable[[Twin], None] = lambda _: None,
    progress: Callable[[float], None] = lambda _: None,
    size: int | None = None,
) -> Run:
    """Run a scene in compiled code, and give its frames to collectors.

    Args:
        scene: The scene.
        outputs: Make the collectors.
        request: Period and number of the frames.
        commands: Set-points at the end of each frame, as `set_points` makes them.
        begin: Called with the twin before its first frame.
        progress: Called with the simulated time [s] after each call of the compiled loop.
        size: Most frames of such a call; `CHUNK` unless given.

    Raises:
        DrillTwinError: The scene cannot be begun; a frame that cannot be followed is part of the outcome.
    """
    began, spent, repeated = time.thread_time(), list[tuple[int, float]](), 0
    error: DrillTwinError | None = None
    twin = Twin(scene)
    begin(twin)
    collectors = [output(twin, request) for output in outputs]
    size = min(size or CHUNK, request.frames)
    record = _record(twin, size) if any(collector.whole for collector in collectors) else None
    rows = twin.rows(size) if record is None else record.rows
    for first in range(0, request.frames, rows.time.size):
        start = time.thread_time()
        given = commands[first : first + rows.time.size]
        again, frames, error = _advance(twin, given, request.period, rows, record)
        count = round(twin.time / request.period) - first
        spent.append((count, time.thread_time() - start))
        repeated += again
        collect(collectors, twin, first_rows(rows, count), request.period, frames)
        progress(twin.time)
        if error is not None or any(collector.ended for collector in collectors):
            break
    values: dict[str, Variable] = {}
    if twin.time > 0.0:
        for collector in collectors:
            values |= collector.close()
    return Run(values, str(error or ""), twin.time, repeated, tuple(spent), time.thread_time() - began)


def _record(twin: Twin, size: int) -> Record:
    one = twin.record(1)
    return twin.record(max(1, min(size, MOST_BYTES // sum(array.nbytes for part in one[:2] for array in part))))


def _advance(
    twin: Twin, commands: Array, period: float, rows: Rows, record: Record | None
) -> tuple[int, Frames | None, DrillTwinError | None]:
    """Advance by frames of a length [s]: how many were repeated, all of them if wanted, the error that ended them."""
    if record is None:
        try:
            return twin.advance_frames(commands, period, rows), None, None
        except DrillTwinError as error:
            return 0, None, error
    frames, ended = twin.fill(record, commands, period)
    if ended is not None and not isinstance(ended, DrillTwinError):
        raise ended
    return len(frames.interventions), frames, ended


def set_points(scene: Scene, times: Sequence[float]) -> Array:
    """Set-points at some times [s]: weight on bit [N], rotation [rad/s], speed of a block [m/s] if any; (F, 2 or 3)."""
    schedule = Schedule.from_scene(scene)
    planned = [schedule.weight_on_bit, schedule.rotation, *([schedule.block] if schedule.block else [])]
    return np.array([[set_point(at) for at in times] for set_point in planned]).T.copy()
