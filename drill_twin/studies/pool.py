# SPDX-License-Identifier: Apache-2.0
"""Runs of a study on several processes."""

import os
import signal
from collections.abc import Callable, Hashable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, TypeVar

from drill_twin.core.process import child_environment

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

    After an error no further job begins. Where a signal ends the study the processes are killed, as a job may take
    minutes.
    """
    os.environ.update(child_environment())  # the workers inherit it when they start
    with ProcessPoolExecutor(workers, mp_context=_Context()) as pool:
        try:
            yield pool
        except Exception:
            pool.shutdown(wait=False, cancel_futures=True)
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
) -> dict[Key, Result]:
    """Call a function with the arguments of each job on worker processes, in the order of the jobs.

    Args:
        function: A function of a module, so that a worker can import it.
        jobs: Arguments by key.
        workers: Processes.
        done: Called with key and result as each job ends.

    Returns:
        Results in the order of the jobs.

    Raises:
        Exception: What the function raised; jobs that have not begun are left out.
    """
    found = dict[Key, Result]()
    with process_pool(workers) as pool:
        running = {pool.submit(function, *arguments): key for key, arguments in jobs.items()}
        for future in as_completed(running):
            key = running[future]
            found[key] = future.result()
            done(key, found[key])
    return {key: found[key] for key in jobs}
