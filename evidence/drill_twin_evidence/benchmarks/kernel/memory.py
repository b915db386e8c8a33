# SPDX-License-Identifier: Apache-2.0
"""Memory over many steps: the time loop allocates nothing, so that a run can go on for ever."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from drill_twin.dynamics.discretisation.kernel_arguments import LATERAL
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.scene.set_points import Schedule
from drill_twin_evidence.benchmarks.kernel.examples import full_scene

LOOKS = 20


def resident() -> float:
    """Memory of this process that is in use now [MiB], as the kernel of Linux counts it."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(float(line.split()[1]) / 1024.0 for line in lines if line.startswith("VmRSS"))


def memory_over(steps: int, elements: int = 50, form: str = LATERAL) -> Iterator[tuple[int, float, float]]:
    """Steps taken, simulated time [s] and memory in use [MiB], at twenty places of a run of so many steps."""
    scene = full_scene(elements, form, rate=1.0)
    schedule = Schedule.from_scene(scene)
    twin = Twin(scene)
    taken, looks = 0, 0
    while taken < steps:
        taken += twin.advance(schedule.at(twin.time + 1.0), 1.0).stats.steps
        if taken * LOOKS >= steps * (looks + 1):
            looks += 1
            yield taken, twin.time, resident()
