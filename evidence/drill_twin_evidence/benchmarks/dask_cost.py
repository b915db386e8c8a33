# SPDX-License-Identifier: Apache-2.0
"""Cost of an ensemble on a Dask cluster, and a reckoning of ten million runs.

    python -m drill_twin_evidence.benchmarks.dask_cost

A scheduler and a worker with one thread are started as processes on this machine. Their processor time, and that of
this process, is measured for short members in tasks of one and of many, which gives the cost of a task and of a member,
and for members of 30 s. Network and machines of unequal speed are not in it.
"""

from __future__ import annotations

import argparse
import math
import os
import pickle
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import drill_twin as dt
from drill_twin.core.table import Table
from drill_twin.runs.ensemble import dask_workers
from drill_twin_evidence.benchmarks.cpu_load import processor_time

RESOLUTION: dict[str, float | str] = {"numerics.elements": 8, "numerics.step": "10 ms"}
LONG, SHORT, IDLE = 30.0, 0.01, 10.0  # [s]
RUNS, CORES = 10_000_000, 1000
PARTS = ("client", "scheduler", "worker")


def main() -> None:
    """Start the cluster, measure, print the table and the reckoning."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--short", type=int, default=1024, help="short members, a square number")
    parser.add_argument("--long", type=int, default=64, help="members of 30 s, a square number")
    given = parser.parse_args()
    size = dask_workers.LARGEST_TASK
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scheduler.json"
        scheduler = start(folder, "scheduler", "--port", "0", "--scheduler-file", str(file))
        while not file.exists():
            time.sleep(0.1)
        worker = start(folder, "worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-nanny")
        address = file.read_text("utf-8").partition('"address": "')[2].partition('"')[0]
        try:
            cluster = (os.getpid(), scheduler.pid, worker.pid)
            measured(address, cluster, 4, SHORT, [0.0] * 3)  # loads the machine code
            idle = idle_share(cluster)
            dask_workers.LARGEST_TASK = 1
            single, _ = measured(address, cluster, given.short, SHORT, idle)
            dask_workers.LARGEST_TASK = size
            many, _ = measured(address, cluster, given.short, SHORT, idle)
            real, bytes_of_run = measured(address, cluster, given.long, LONG, idle)
        finally:
            for process in (worker, scheduler):
                process.kill()
                process.wait()
    tasks = given.short - given.short / size
    of_task = [1e3 * (one - other) / tasks for one, other in zip(single, many, strict=True)]
    of_member = [1e3 * other / given.short - cost / size for other, cost in zip(many, of_task, strict=True)]
    of_member[2] = 1e3 * real[2] / given.long
    costs = zip(PARTS, (f"{ms:.2f}" for ms in of_task), (f"{ms:.3g}" for ms in of_member), strict=True)
    print(Table(("processor time, ms", "of a task", "of a member"), costs).markdown())
    client, served, work = (
        RUNS * (member + task / size) / 6e4 for member, task in zip(of_member, of_task, strict=True)
    )
    print(
        f"\n{RUNS:.0e} members of {LONG:g} s in tasks of {size}: workers {work / CORES:.0f} min on {CORES} cores, "
        f"scheduler {served:.1f} min, client {client:.0f} min, results {RUNS * bytes_of_run / 1e9:.0f} GB\n"
        f"cores that one scheduler serves: {work / served:.0f}; one client: {work / client:.0f}"
    )


def start(folder: str, kind: str, *words: str) -> subprocess.Popen[bytes]:
    """Start a scheduler or a worker, whose ports are of this machine alone: they run what anybody sends."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *words, "--host", "127.0.0.1"]
    command += ["--no-dashboard", "--dashboard-address", "127.0.0.1:0"]
    return subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def idle_share(processes: tuple[int, ...]) -> list[float]:
    """Share of a core that each process takes while it waits."""
    before = [processor_time(process) for process in processes]
    time.sleep(IDLE)
    return [(processor_time(process) - then) / IDLE for process, then in zip(processes, before, strict=True)]


def measured(
    address: str, processes: tuple[int, ...], members: int, duration: float, idle: list[float]
) -> tuple[list[float], float]:
    """Processor time of each process for an ensemble, without that of waiting [s], and bytes of a member's result."""
    scene, side = dt.load_scene("pa6_bench", RESOLUTION), math.isqrt(members)
    before, began = [processor_time(process) for process in processes], time.monotonic()
    ensemble = dt.Ensemble(scene, {"wob": np.linspace(20.0, 50.0, side).tolist(), "seed": range(side)})
    found = ensemble.run(duration, dask=address)
    wall = time.monotonic() - began
    costs = [
        processor_time(one) - then - wall * share for one, then, share in zip(processes, before, idle, strict=True)
    ]
    return costs, len(pickle.dumps(found.runs)) / len(found.runs)


if __name__ == "__main__":
    main()
