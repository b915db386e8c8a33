# SPDX-License-Identifier: Apache-2.0
"""Runs of the members of an ensemble, and the threads that make them: the compiled frame loop releases the GIL."""

import time
from collections.abc import Callable, Generator, Hashable, Mapping
from concurrent.futures import CancelledError, ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from threading import Event
from typing import Protocol, TypeVar

from drill_twin.core.errors import DrillTwinError
from drill_twin.dynamics.solver.slices import checked
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.runs.ensemble.members import Member, Members, scene_of
from drill_twin.runs.ensemble.outputs import OUTPUTS, Request, Variable
from drill_twin.runs.ensemble.parts import parts_of
from drill_twin.scene import Scene

Key = TypeVar("Key", bound=Hashable)
Item = TypeVar("Item")
Result = TypeVar("Result")


@dataclass(frozen=True)
class MemberRun:
    """Outcome of a member.

    Attributes:
        values: Outputs by name; of a member that failed, the outputs of the frames before.
        failure: The reason why the member could not be followed to the end; empty if it was.
        simulated: Simulated time [s].
        processor_seconds: Processor time in all [s].
    """

    values: Mapping[str, Variable] = field(default_factory=dict)
    failure: str = ""
    simulated: float = 0.0
    processor_seconds: float = 0.0


class Executor(Protocol):
    """Place where members are run: `Threads` of this process, or
    `drill_twin.runs.ensemble.dask_workers.DaskWorkers`.
    """

    def run(self, members: Members, request: Request) -> Generator[tuple[int, MemberRun]]:
        """Run all members; the results have the same bits on every executor.

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

    def run(self, members: Members, request: Request) -> Generator[tuple[int, MemberRun]]:
        """As in `Executor`."""
        jobs = {member.number: member for member in members}
        yield from on_threads(lambda member, _: run_member(members.base, request, member), jobs, self.workers)


def on_threads(
    function: Callable[[Item, Callable[[float], None]], Result], items: Mapping[Key, Item], workers: int
) -> Generator[tuple[Key, Result]]:
    """Call a function with each item on threads.

    Args:
        function: Takes an item, and a callback for the simulated time [s]; an error in the callback ends the function.
        items: Items by key.
        workers: Threads.

    Yields:
        Key and result of each, as they end.
    """
    pool, stop = ThreadPoolExecutor(max(1, min(workers, len(items))), "member"), Event()

    def goes_on(_time: float = 0.0) -> None:
        if stop.is_set():
            raise CancelledError

    def call(item: Item) -> Result:
        with checked(goes_on):
            return function(item, goes_on)

    try:
        waiting = {pool.submit(call, item): key for key, item in items.items()}
        for future in as_completed(waiting):
            yield waiting.pop(future), future.result()
    finally:
        stop.set()
        pool.shutdown(cancel_futures=True)


def run_member(base: Scene, request: Request, member: Member) -> MemberRun:
    """Run one member of a base scene; its failure is part of the outcome."""
    began = time.thread_time()
    failure, simulated = "", 0.0
    values: dict[str, Variable] = {}
    try:
        scene = scene_of(base, member)
        twin = Twin(scene)
        collectors = [OUTPUTS[name](twin, request) for name in request.names]
        try:
            for part in parts_of(twin, request.commands(scene), request.period):
                simulated = twin.time
                for collector in collectors:
                    collector.add(part.rows, part.rig)
        except DrillTwinError as error:
            failure = str(error)
        if simulated > 0.0:
            for collector in collectors:
                values |= collector.close()
    except DrillTwinError as error:
        failure = failure or str(error)
    except MemoryError:
        failure = (
            f"{member}: expected room for its arrays, found no memory left; take fewer workers or a lower mark_rate"
        )
    return MemberRun(values, failure, simulated, time.thread_time() - began)
