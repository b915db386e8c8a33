# SPDX-License-Identifier: Apache-2.0
"""Processor time of a run by what is done with it, over that of the compiled loop.

    python -m drill_twin_evidence.benchmarks.ensemble_cost

`pa6_bench` with 8 elements and steps of 10 ms, 30 s simulated, on one thread. All cases are measured in turn, several
times, and the least of each counts. Start-up and compiling are left out. So are the samples of the analyzer, and the
time by the clock of 32 members on one thread over that on two, which says something on a quiet machine only.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import drill_twin as dt
from drill_twin.core.table import Table
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.io.scene_geometry import mark_infos
from drill_twin.runs import Session
from drill_twin.runs.ensemble.parts import parts_of, planned
from drill_twin.scene.set_points import Schedule
from drill_twin.whirl import Analyzer, MarkInfo

DURATION, RATE = 30.0, 100  # [s], frames a second
RESOLUTION: dict[str, float | str] = {"numerics.elements": 8, "numerics.step": "10 ms", "duration": DURATION}
LOOP = "compiled loop, frames of 1 s"
MEMBERS = 4


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    rounds: int = parser.parse_args().rounds
    scene = dt.load_scene("pa6_bench", RESOLUTION)
    ensemble = dt.Ensemble(scene, {"seed": range(MEMBERS)})
    shares: list[float] = []

    def members(*outputs: str) -> float:
        found = ensemble.run(outputs=outputs, workers=1)
        kernel = sum(run.kernel_seconds for run in found.runs)
        shares.append(kernel / found.processor_seconds)
        return found.processor_seconds / MEMBERS

    cases: dict[str, Callable[[], float]] = {
        LOOP: lambda: loop(scene),
        "twin, 100 frames a second, one at a time": lambda: twin(scene),
        "twin, 100 frames a second, 100 at a time": lambda: blocks(scene),
        "member without findings": lambda: members("extremes", "contact"),
        "member with findings": lambda: members("findings", "extremes", "contact"),
        "recorded run: analysis and bag": lambda: recorded(scene),
    }
    for measure in cases.values():  # loads the machine code
        measure()
    shares.clear()
    least = dict.fromkeys(cases, math.inf)
    for _ in range(rounds):
        for name, measure in cases.items():
            least[name] = min(least[name], measure())
    rows = ((name, f"{1e3 * seconds:.0f}", f"{seconds / least[LOOP]:.1f}") for name, seconds in least.items())
    print(Table(("processor time of 30 s of `pa6_bench`", "ms", "over the compiled loop"), rows).markdown())
    ways = zip(("one `push` for each", "many in a block"), pushed(scene, rounds), strict=True)
    pushes = ((name, f"{1e6 * seconds / (DURATION * RATE):.1f}") for name, seconds in ways)
    print(f"\n{Table(('analyzer, 4 marks', 'us a sample'), pushes).markdown()}")
    print(f"\n32 members on two threads: {two_threads(scene, rounds):.2f} times as fast as on one")
    print(
        f"\nshare of the compiled loop without findings {max(shares[::2]):.0%}, with findings {max(shares[1::2]):.0%}"
    )


def loop(scene: dt.Scene) -> float:
    """Processor time of the compiled loop alone [s]."""
    dynamics, schedule = Twin(scene).dynamics, Schedule.from_scene(scene)
    began = time.process_time()
    for second in range(1, round(DURATION) + 1):
        target = schedule.at(float(second)).array()
        dynamics.advance(target, 1.0)
        dynamics.command[:] = target
    return time.process_time() - began


def twin(scene: dt.Scene) -> float:
    """Processor time of a twin that makes a frame every 10 ms [s]."""
    running, schedule = Twin(scene), Schedule.from_scene(scene)
    began = time.process_time()
    for frame in range(1, round(DURATION * RATE) + 1):
        running.advance(schedule.at(frame / RATE), 1.0 / RATE)
    return time.process_time() - began


def blocks(scene: dt.Scene) -> float:
    """The same by many frames in a call, as a recorded run does [s]."""
    running, schedule = Twin(scene), Schedule.from_scene(scene)
    record = running.record(RATE)
    began = time.process_time()
    for second in range(round(DURATION)):
        commands = (schedule.at(second + frame / RATE) for frame in range(1, RATE + 1))
        running.fill(record, np.array([command.array() for command in commands]), 1.0 / RATE)
    return time.process_time() - began


def recorded(scene: dt.Scene) -> float:
    """Processor time of a session, as `drill-twin run` [s]."""
    session = Session(scene)
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        session.run(Path(folder) / "bag_0")
        return time.process_time() - began


def pushed(scene: dt.Scene, rounds: int) -> tuple[float, float]:
    """Least processor times of the analysis of a run: sample by sample, and in one block [s]."""
    running, infos = Twin(scene), mark_infos(scene)
    rows, rig, _, _ = next(parts_of(running, *planned(scene)))
    stamps = np.rint(rows.time * 1e9).astype(np.int64)
    columns = (rows.position, rows.spin, rig.top_drive_speed, rows.wall_force, rig.bit_speed)
    samples = list(zip(stamps.tolist(), *columns, strict=True))

    def one_by_one(analyzer: Analyzer) -> None:
        for sample in samples:
            analyzer.push(*sample)

    return timed(infos, one_by_one, rounds), timed(infos, lambda one: one.push_block(stamps, *columns), rounds)


def timed(infos: Sequence[MarkInfo], analyse: Callable[[Analyzer], object], rounds: int) -> float:
    """Least processor time of an analysis [s]."""
    least = math.inf
    for _ in range(rounds):
        analyzer = Analyzer(infos)
        began = time.process_time()
        analyse(analyzer)
        least = min(least, time.process_time() - began)
    return least


def two_threads(scene: dt.Scene, rounds: int) -> float:
    """Least time by the clock of an ensemble on one thread over that on two; two cores must be free."""
    ensemble = dt.Ensemble(scene, {"seed": range(32)})
    least = {1: math.inf, 2: math.inf}
    for _ in range(rounds):
        for workers in (1, 2):
            began = time.perf_counter()
            ensemble.run(workers=workers)
            least[workers] = min(least[workers], time.perf_counter() - began)
    return least[1] / least[2]


if __name__ == "__main__":
    main()
