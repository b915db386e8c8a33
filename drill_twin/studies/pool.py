# SPDX-License-Identifier: Apache-2.0
"""Runs of a study on several processes."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import ExitStack, contextmanager
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, TypeVar

from drill_twin.core.process.child_environment import child_environment

Key = TypeVar("Key", bound=Hashable)
Result = TypeVar("Result")


def cores() -> int:
    """Processor cores that this process may use."""
    return len(os.sched_getaffinity(0))


class _Worker(SpawnProcess):
    """Process that starts with SIGINT blocked: Ctrl-C reaches all processes of a terminal."""

    def start(self) -> None:
        """Start the process."""
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Context(SpawnContext):
    Process = _Worker


@contextmanager
def process_pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Worker processes; spawned, because a forked process inherits numba's locks.

    Where a signal ends the study they are killed: a job may take minutes.
    """
    os.environ.update(child_environment())  # of the workers, which start later
    with ProcessPoolExecutor(workers, mp_context=_Context()) as pool:
        try:
            yield pool
        except Exception:
            raise
        except BaseException:
            for process in tuple((pool._processes or {}).values()):  # noqa: SLF001  kill_workers comes in Python 3.14
                process.kill()
            raise


def run_jobs(
    function: Callable[..., Result],
    jobs: Mapping[Key, tuple[Any, ...]],
    workers: int,
    *,
    done: Callable[[Key, Result], None] = lambda _key, _result: None,
    kernel: Callable[[Key], str] = lambda _: "",
) -> dict[Key, Result]:
    """Call a function with the arguments of each job on worker processes.

    Jobs start in their order, except that a worker stays with the jobs of one kernel while there are any: each kernel
    is then compiled or loaded by few processes.

    Args:
        function: A function of a module, so that a worker can import it.
        jobs: Arguments by key.
        workers: Processes.
        done: Called with key and result as each job ends.
        kernel: Name of the kernel that a job needs.

    Returns:
        Results in the order of the jobs.

    Raises:
        Exception: What the function raised; jobs that have not begun are left out.
    """
    waiting, found = list(jobs), dict[Key, Result]()
    with ExitStack() as stack:
        pools = [stack.enter_context(process_pool(1)) for _ in range(min(workers, len(waiting)))]
        last = [""] * len(pools)
        running = dict[Future[Result], tuple[int, Key]]()

        def start(worker: int) -> None:
            names = [kernel(key) for key in waiting]
            key = waiting.pop(_next(names, last[worker], [*last[:worker], *last[worker + 1 :]]))
            last[worker] = kernel(key)
            running[pools[worker].submit(function, *jobs[key])] = worker, key

        for worker in range(len(pools)):
            start(worker)
        while running:
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                worker, key = running.pop(future)
                found[key] = future.result()
                done(key, found[key])
                if waiting:
                    start(worker)
    return {key: found[key] for key in jobs}


def _next(kernels: Sequence[str], own: str, others: Sequence[str]) -> int:
    """Index of the job to start: of the worker's own kernel, else of one that no other worker runs, else the first."""
    if own in kernels:
        return kernels.index(own)
    return next((index for index, name in enumerate(kernels) if name not in others), 0)
