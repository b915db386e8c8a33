# SPDX-License-Identifier: Apache-2.0
"""Many runs at once, on as many processes as wanted."""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing import get_context
from typing import TypeVar

from drill_twin.scene import Scene
from drill_twin.schedule import Schedule
from drill_twin.studies.paper.runs.run import Run, run
from drill_twin.twin.twin import Twin

Key = TypeVar("Key", bound=Hashable)
Done = Callable[[Key], None]


def cores() -> int:
    """Processor cores this process may use."""
    return len(os.sched_getaffinity(0))


@contextmanager
def pool(processes: int) -> Iterator[ProcessPoolExecutor]:
    """Worker processes with one thread each; spawned, for a forked numba would share its locks."""
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as workers:
        yield workers


def compile_for(scene: Scene) -> None:
    """Compile the kernel of a scene here, so that the workers find it in the cache."""
    schedule, period = Schedule.from_scene(scene), 1.0 / scene.numerics.frame_rate
    Twin(scene).advance(schedule.at(period), period)


def run_all(scenes: Mapping[Key, Scene], processes: int, done: Callable[[Key, Run], None]) -> None:
    """Run every scene to its end; in this process where only one is wanted.

    Args:
        scenes: What to run, by any key; the costly ones first keep all processes busy.
        processes: How many at once.
        done: Called with each run as it ends.

    Raises:
        RunError: A run could not even begin.
    """
    if processes == 1:
        for key, scene in scenes.items():
            done(key, run(scene))
        return
    with pool(processes) as workers:
        futures = {workers.submit(run, scene): key for key, scene in scenes.items()}
        for future in as_completed(futures):
            done(futures[future], future.result())
