# SPDX-License-Identifier: Apache-2.0
"""Processor time of the time loop by itself, and memory over many steps."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Schedule

LOOKS = 20
"""Looks at the memory over a run."""


@dataclass(frozen=True)
class Cost:
    """Cost of a piece of a run."""

    elements: int
    steps: int
    iterations: int
    seconds: float
    """Processor time [s]."""

    @property
    def per_step(self) -> float:
        """Of one element in one step [ns]."""
        return self.seconds / self.steps / self.elements * 1e9

    @property
    def per_iteration(self) -> float:
        """Of one element in one Newton iteration [ns]."""
        return self.seconds / self.iterations / self.elements * 1e9


def least_cost(scene: Scene, settle: float = 0.4, repeats: int = 5) -> Cost:
    """The cheapest of a few frames after the motion has begun: the one least disturbed by others on the machine.

    A frame of these scenes holds a hundred steps, so that set-points and reading of the state do not count.

    Args:
        scene: What to run; it is compiled first, outside the cost.
        settle: Simulated time to leave out at the beginning [s].
        repeats: Frames to choose from.
    """
    schedule = Schedule.from_scene(scene)
    period = 1.0 / scene.numerics.frame_rate
    twin = Twin(scene)
    for frame in range(1, max(1, round(settle / period)) + 1):
        twin.advance(schedule.at(frame * period), period)
    costs = []
    for _ in range(repeats):
        began = time.process_time()
        stats = twin.advance(schedule.at(twin.time + period), period).stats
        costs.append(Cost(twin.elements, stats.steps, stats.iterations, time.process_time() - began))
    return min(costs, key=lambda cost: cost.per_iteration)


def resident() -> float:
    """Memory of this process that is in use now [MiB], as the kernel of Linux counts it."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(float(line.split()[1]) / 1024.0 for line in lines if line.startswith("VmRSS"))


def memory_over(scene: Scene, steps: int) -> Iterator[tuple[int, float, float]]:
    """Steps taken, simulated time [s] and memory in use [MiB], at twenty places of a run of so many steps.

    The time loop allocates nothing, so that a run can go on for ever.
    """
    schedule = Schedule.from_scene(scene)
    twin = Twin(scene)
    taken, looks = 0, 0
    while taken < steps:
        taken += twin.advance(schedule.at(twin.time + 1.0), 1.0).stats.steps
        if taken * LOOKS >= steps * (looks + 1):
            looks += 1
            yield taken, twin.time, resident()
