# SPDX-License-Identifier: Apache-2.0
"""Place where the members of an ensemble are run: threads of this process, or the workers of a Dask scheduler."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from drill_twin.core.errors import ArgumentError
from drill_twin.runs.ensemble import Executor, Threads

MOST_THREADS = 4096


@contextmanager
def executor_of(workers: int | None, dask: str | None) -> Iterator[Executor]:
    """Threads, or the workers of a scheduler until the end of the `with` block.

    Args:
        workers: Threads; None: one for each processor core.
        dask: Address of a Dask scheduler; None or empty: threads.

    Raises:
        ArgumentError: The number is absurd, or distributed is not installed.
        RunError: No scheduler answers at the address, or it has no workers.
    """
    if dask:
        from drill_twin.runs.ensemble.dask_workers import DaskWorkers

        with DaskWorkers(dask) as cluster:
            yield cluster
        return
    threads = len(os.sched_getaffinity(0)) if workers is None else workers
    if not isinstance(threads, int) or not 1 <= threads <= MOST_THREADS:
        raise ArgumentError(f"workers: expected a whole number of 1 or more, found {workers!r}")
    yield Threads(threads)
